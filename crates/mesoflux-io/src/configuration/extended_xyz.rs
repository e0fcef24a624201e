//! Extended XYZ: the number of particles, a line of keys with values, and a line of columns for every particle.
//!
//! Of the keys, `Lattice` is the box, `Properties` the columns, `Origin` the box's lower corner and `pbc` must be all true.
//! Of the columns, `species` (or `element`, or `type`), `pos`, `velo`, `momenta`, `mass` and their other names are read.
//! Other keys and columns are passed over. Of several frames, the last one counts, but every one must be right.

use super::text::{self, Lines, MOST_KINDS, MOST_PARTICLES, shown};
use super::{Configuration, ConfigurationError, Motion, Named};
use mesoflux_core::vector::{Vector, ZERO};

/// The columns where `Properties` doesn't say.
const USUAL_PROPERTIES: &str = "species:S:1:pos:R:3";
/// What a message gives as an example of keys.
const EXAMPLE: &str = "Lattice=\"10 0 0 0 10 0 0 0 10\"";
/// The names of the column of species, best first: files have `type` beside `species`.
const SPECIES: [&str; 3] = ["species", "element", "type"];
const VELOCITIES: [&str; 4] = ["velo", "vel", "velocity", "velocities"];
const MOMENTA: [&str; 3] = ["momenta", "momentum", "p"];
const MASSES: [&str; 2] = ["mass", "masses"];
/// A property takes at most so many columns.
const MOST_COLUMNS: u64 = 1_000_000;
/// Masses of one species agree to this part of them.
const MASS_TOLERANCE: f64 = 1e-9;
/// The shortest particle line, "H 0 0 0" and its end.
const SHORTEST_PARTICLE: usize = 8;

/// Reads the particles in `text`; messages call it `name`.
///
/// # Errors
/// The first thing in the text that is wrong, with its line.
pub fn parse(name: &str, text: &[u8]) -> Result<Configuration, ConfigurationError> {
    let mut lines = Lines::new(name, text)?;
    let mut last: Option<Frame> = None;
    loop {
        let Some(line) = lines.find(|line| !line.is_empty()) else {
            return last.map(|frame| frame.configuration).ok_or_else(|| {
                lines.wrong("the number of particles is missing: must be the first line, but the file is empty")
            });
        };
        let first = lines.number();
        // After a whole frame, what isn't a number is more likely a particle too many than a wrong count.
        if let Some(frame) = last.as_ref().filter(|_| line.parse::<f64>().is_err()) {
            let (count, begin) = (frame.configuration.kinds.len(), frame.first);
            return Err(lines.wrong(format!(
                "surplus line = \"{}\": must be the number of particles of another frame, because line {begin} promises \
                 {count} for the one before",
                shown(line)
            )));
        }
        if line.contains(|character: char| character.is_ascii_whitespace()) {
            let reason = format!("number of particles = \"{}\": must be a whole number alone on its line", shown(line));
            return Err(lines.wrong(reason));
        }
        let count = text::integer("number of particles", line, 1..=MOST_PARTICLES);
        let count = count.map_err(|reason| lines.wrong(reason))?;
        last = Some(Frame { first, configuration: read_frame(&mut lines, count)? });
    }
}

/// One frame, and the line where it begins.
struct Frame {
    first: u64,
    configuration: Configuration,
}

/// Reads the keys and the particles of a frame, after its `count`.
fn read_frame(lines: &mut Lines, count: u64) -> Result<Configuration, ConfigurationError> {
    let promise = lines.number();
    let Some(keys) = lines.next() else {
        return Err(lines.wrong(format!(
            "the line of keys is missing: must follow the number of particles, as in {EXAMPLE}, but the file ends here"
        )));
    };
    let header = read_keys(keys).map_err(|reason| lines.wrong(reason))?;
    let mut particles = Particles::with_room(lines.room(count, SHORTEST_PARTICLE), &header.columns);
    let mut words = Vec::new();
    for found in 0..count {
        let Some(line) = lines.next() else {
            return Err(lines.wrong(format!(
                "particles = {found} where the file ends: must be {count}, as line {promise} promises"
            )));
        };
        words.clear();
        words.extend(line.split_ascii_whitespace());
        if words.len() as u64 != header.columns.width {
            return Err(lines.wrong(format!(
                "columns = {}: must be {} for particle {} of the {count} that line {promise} promises, because Properties=\"{}\"",
                words.len(),
                header.columns.width,
                found + 1,
                shown(header.columns.properties)
            )));
        }
        particles.add(&words, &header, lines.number()).map_err(|reason| lines.wrong(reason))?;
    }
    Ok(particles.finish(header.sides))
}

/// What the line of keys says.
struct Header<'a> {
    sides: Vector,
    origin: Vector,
    columns: Columns<'a>,
}

/// Where the columns are that are read.
struct Columns<'a> {
    properties: &'a str,
    width: u64,
    species: usize,
    /// Whether species are whole numbers.
    numbered: bool,
    position: usize,
    motion: Option<(usize, MotionKind)>,
    mass: Option<usize>,
}

#[derive(Clone, Copy)]
enum MotionKind {
    Velocities,
    Momenta,
}

/// The keys and values of a line.
fn read_keys(line: &str) -> Result<Header<'_>, String> {
    let [mut lattice, mut properties, mut origin, mut periodic] = [None; 4];
    let mut rest = line;
    while let Some((key, value)) = take_pair(&mut rest)? {
        let place = match key {
            "Lattice" | "lattice" => &mut lattice,
            "Properties" | "properties" => &mut properties,
            "Origin" | "origin" => &mut origin,
            "pbc" => &mut periodic,
            _ => continue,
        };
        if let Some(before) = place.replace(value) {
            return Err(format!(
                "{key} = \"{}\": must be given once, and this line has \"{}\" already",
                shown(value),
                shown(before)
            ));
        }
    }
    let Some(lattice) = lattice else {
        return Err(format!("Lattice is missing: must give the box, as in {EXAMPLE}"));
    };
    if let Some(value) = periodic {
        let mut words = value.split_ascii_whitespace();
        if words.clone().count() != 3 || !words.all(|word| matches!(word, "T" | "True" | "TRUE" | "true")) {
            return Err(format!("pbc = \"{}\": must be \"T T T\", because the box is periodic", shown(value)));
        }
    }
    let sides = read_lattice(lattice)?;
    let origin = origin.map_or(Ok(ZERO), |value| read_numbers("Origin", value))?;
    Ok(Header { sides, origin, columns: read_properties(properties.unwrap_or(USUAL_PROPERTIES))? })
}

/// Takes a key and its value off the line; a key without a value has an empty one.
fn take_pair<'a>(rest: &mut &'a str) -> Result<Option<(&'a str, &'a str)>, String> {
    *rest = rest.trim_ascii_start();
    if rest.is_empty() {
        return Ok(None);
    }
    let key = match rest.as_bytes().first() {
        Some(b'"') => take_quoted(rest)?,
        _ => take_until(rest, |byte| byte == b'=' || byte.is_ascii_whitespace()),
    };
    let after = rest.trim_ascii_start();
    let Some(after) = after.strip_prefix('=') else {
        return Ok(Some((key, "")));
    };
    *rest = after.trim_ascii_start();
    let value = match rest.as_bytes().first() {
        Some(b'"' | b'\'') => take_quoted(rest)?,
        Some(b'{' | b'[') => take_bracketed(rest)?,
        _ => take_until(rest, |byte| byte.is_ascii_whitespace()),
    };
    Ok(Some((key, value)))
}

/// Takes everything before the first byte that is an end.
fn take_until<'a>(rest: &mut &'a str, end: impl Fn(u8) -> bool) -> &'a str {
    let length = rest.bytes().position(end).unwrap_or(rest.len());
    let (taken, after) = rest.split_at(length);
    *rest = after;
    taken
}

/// Takes what stands between the quotation mark that the text begins with and the next one of its kind.
fn take_quoted<'a>(rest: &mut &'a str) -> Result<&'a str, String> {
    let bytes = rest.as_bytes();
    let mut place = 1;
    while let Some(byte) = bytes.get(place) {
        match byte {
            b'\\' => place += 2,
            _ if *byte == bytes[0] => {
                let taken = &rest[1..place];
                *rest = &rest[place + 1..];
                return Ok(taken);
            }
            _ => place += 1,
        }
    }
    Err(format!("value = {}: must end with a quotation mark, as it begins", shown(rest)))
}

/// Takes what stands between the bracket that the text begins with and the one that closes it.
fn take_bracketed<'a>(rest: &mut &'a str) -> Result<&'a str, String> {
    let bytes = rest.as_bytes();
    let (open, close) = if bytes[0] == b'{' { (b'{', b'}') } else { (b'[', b']') };
    let mut depth = 0u64;
    let mut quoted = false;
    for (place, byte) in bytes.iter().enumerate() {
        match *byte {
            b'"' => quoted = !quoted,
            byte if byte == open && !quoted => depth += 1,
            byte if byte == close && !quoted => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            let taken = &rest[1..place];
            *rest = &rest[place + 1..];
            return Ok(taken);
        }
    }
    Err(format!("value = {}: must end with {}, as it begins with {}", shown(rest), close as char, open as char))
}

/// The numbers that a value holds, exactly as many as are asked for.
fn read_numbers<const COUNT: usize>(key: &str, value: &str) -> Result<[f64; COUNT], String> {
    let found = value.split_ascii_whitespace().count();
    if found != COUNT {
        return Err(format!("{key} = \"{}\": must be {COUNT} numbers, but these are {found}", shown(value)));
    }
    let mut numbers = [0.0; COUNT];
    for (place, word) in value.split_ascii_whitespace().enumerate() {
        numbers[place] = text::number(format_args!("number {} of {key}", place + 1), word)?;
    }
    Ok(numbers)
}

/// The sides of an orthorhombic box.
fn read_lattice(value: &str) -> Result<Vector, String> {
    let lattice: [f64; 9] = read_numbers("Lattice", value)?;
    let sides = [lattice[0], lattice[4], lattice[8]];
    for (side, name) in sides.into_iter().zip(["L_x", "L_y", "L_z"]) {
        if side <= 0.0 {
            return Err(format!("{name} of Lattice = {side:?}: must be positive"));
        }
    }
    for (place, component) in lattice.into_iter().enumerate() {
        if place % 4 != 0 && component != 0.0 {
            return Err(format!(
                "number {} of Lattice = {component:?}: must be 0, because the box is orthorhombic, as in {EXAMPLE}",
                place + 1
            ));
        }
    }
    Ok(sides)
}

/// One entry of Properties.
struct Property<'a> {
    name: &'a str,
    kind: &'a str,
    count: u64,
    start: u64,
}

impl Property<'_> {
    /// Where its columns begin, if it is of one of these kinds and takes `count` columns.
    fn start(&self, kinds: &[&str], count: u64) -> Result<usize, String> {
        let Self { name, kind, count: found, start } = self;
        if kinds.contains(kind) && *found == count {
            return Ok(*start as usize);
        }
        let wanted: Vec<String> = kinds.iter().map(|kind| format!("{name}:{kind}:{count}")).collect();
        Err(format!("entry of Properties = {name}:{kind}:{found}: must be {}", wanted.join(" or ")))
    }
}

/// The one property that has one of the names, of those that Properties has by its `value`.
fn the_one<'a, 'b>(
    properties: &'b [Property<'a>],
    names: &[&str],
    value: &str,
) -> Result<Option<&'b Property<'a>>, String> {
    let mut those = properties.iter().filter(|property| names.contains(&property.name));
    let (first, second) = (those.next(), those.next());
    let requirement = match (first, second) {
        (Some(first), Some(second)) if first.name == second.name => format!("name {} once", first.name),
        (Some(first), Some(second)) => format!("name {} or {}, not both", first.name, second.name),
        _ => return Ok(first),
    };
    Err(format!("Properties = \"{}\": must {requirement}", shown(value)))
}

/// The columns that Properties names.
fn read_properties(value: &str) -> Result<Columns<'_>, String> {
    let mut properties = Vec::new();
    let mut width = 0;
    let mut fields = value.split(':');
    while let Some(name) = fields.next() {
        let (Some(kind), Some(count)) = (fields.next(), fields.next()) else {
            return Err(format!(
                "Properties = \"{}\": must be of the form name:kind:count:name:kind:count, as in {USUAL_PROPERTIES}",
                shown(value)
            ));
        };
        if !matches!(kind, "S" | "I" | "R" | "L") {
            let (kind, name) = (shown(kind), shown(name));
            return Err(format!("kind of {name} in Properties = {kind}: must be S, I, R or L"));
        }
        let count = text::integer(format_args!("count of {} in Properties", shown(name)), count, 1..=MOST_COLUMNS)?;
        properties.push(Property { name, kind, count, start: width });
        width += count;
    }
    let missing =
        |what: &str| format!("{what} is missing in Properties = \"{}\": must be among the columns", shown(value));

    let mut species = None;
    for name in SPECIES {
        species = species.or(the_one(&properties, &[name], value)?);
    }
    let species = species.ok_or_else(|| missing("species:S:1"))?;
    let position = the_one(&properties, &["pos"], value)?.ok_or_else(|| missing("pos:R:3"))?;
    let motion = match (the_one(&properties, &VELOCITIES, value)?, the_one(&properties, &MOMENTA, value)?) {
        (Some(velocities), Some(momenta)) => {
            let (velocities, momenta) = (velocities.name, momenta.name);
            return Err(format!("Properties = \"{}\": must name {velocities} or {momenta}, not both", shown(value)));
        }
        (Some(velocities), None) => Some((velocities.start(&["R"], 3)?, MotionKind::Velocities)),
        (None, Some(momenta)) => Some((momenta.start(&["R"], 3)?, MotionKind::Momenta)),
        (None, None) => None,
    };
    let mass = the_one(&properties, &MASSES, value)?.map(|mass| mass.start(&["R"], 1)).transpose()?;
    Ok(Columns {
        properties: value,
        width,
        species: species.start(&["S", "I"], 1)?,
        numbered: species.kind == "I",
        position: position.start(&["R"], 3)?,
        motion,
        mass,
    })
}

/// The particles of a frame as far as they are read.
struct Particles {
    species: Vec<Named>,
    /// The species of the particle before: the next one's is most likely the same.
    latest: usize,
    /// By species, the mass and the line that gives it.
    masses: Vec<Option<(f64, u64)>>,
    kinds: Vec<u32>,
    positions: Vec<Vector>,
    motion: Option<Motion>,
}

impl Particles {
    fn with_room(room: usize, columns: &Columns) -> Self {
        let motion = columns.motion.map(|(_, kind)| match kind {
            MotionKind::Velocities => Motion::Velocities(Vec::with_capacity(room)),
            MotionKind::Momenta => Motion::Momenta(Vec::with_capacity(room)),
        });
        let (kinds, positions) = (Vec::with_capacity(room), Vec::with_capacity(room));
        Self { species: Vec::new(), latest: 0, masses: Vec::new(), kinds, positions, motion }
    }

    /// Adds the particle of a line, whose words are as many as the columns.
    fn add(&mut self, words: &[&str], header: &Header, line: u64) -> Result<(), String> {
        let columns = &header.columns;
        let kind = self.kind(words[columns.species], columns.numbered, line)?;
        self.kinds.push(kind as u32);
        self.positions.push(text::position(&words[columns.position..][..3], header.origin)?);
        if let (Some(motion), Some((start, _))) = (&mut self.motion, columns.motion) {
            let words = &words[start..][..3];
            match motion {
                Motion::Velocities(all) => all.push(text::vector(["v_x", "v_y", "v_z"], words)?),
                Motion::Momenta(all) => all.push(text::vector(["p_x", "p_y", "p_z"], words)?),
            }
        }
        if let Some(column) = columns.mass {
            let mass = text::positive("mass", words[column])?;
            let (first, place) = *self.masses[kind].get_or_insert((mass, line));
            if !((mass - first).abs() <= MASS_TOLERANCE * first) {
                return Err(format!(
                    "mass = {}: must be {first:?}, as in line {place}, because both particles are of species {}",
                    shown(words[column]),
                    shown(&self.species[kind].name)
                ));
            }
        }
        Ok(())
    }

    /// The number of the species that a word names.
    fn kind(&mut self, word: &str, numbered: bool, line: u64) -> Result<usize, String> {
        if let Some(kind) = self.find(word) {
            return Ok(kind);
        }
        let mut name = word.to_owned();
        if numbered {
            // 7, +7 and 07 are one species.
            let number: Result<i64, _> = word.parse();
            let number = number.map_err(|_| format!("species = {}: must be a whole number of 64 bits", shown(word)))?;
            name = number.to_string();
            if let Some(kind) = self.find(&name) {
                return Ok(kind);
            }
        }
        if self.species.len() as u64 == MOST_KINDS {
            return Err(format!(
                "species = {}: must be one of the {MOST_KINDS} before it, for there can't be more",
                shown(word)
            ));
        }
        self.species.push(Named { name, line });
        self.masses.push(None);
        self.latest = self.species.len() - 1;
        Ok(self.latest)
    }

    fn find(&mut self, name: &str) -> Option<usize> {
        if self.species.get(self.latest).is_none_or(|latest| latest.name != name) {
            self.latest = self.species.iter().position(|named| named.name == name)?;
        }
        Some(self.latest)
    }

    fn finish(self, sides: Vector) -> Configuration {
        Configuration {
            sides,
            species: self.species,
            kinds: self.kinds,
            positions: self.positions,
            motion: self.motion,
            masses: self.masses.into_iter().map(|mass| mass.map(|(mass, _)| mass)).collect(),
            bonds: Vec::new(),
            bond_kinds: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(line: &str) -> Result<Vec<(&str, &str)>, String> {
        let mut rest = line;
        let mut pairs = Vec::new();
        while let Some(pair) = take_pair(&mut rest)? {
            pairs.push(pair);
        }
        Ok(pairs)
    }

    #[test]
    fn keys_and_values_come_in_all_the_ways_that_the_format_has() {
        let line = r#"a=1 b="two words" "c d"='e' f g = [[1, "]"], [2]] h={0 1} i="a\"b" j="#;
        let expected = [
            ("a", "1"),
            ("b", "two words"),
            ("c d", "e"),
            ("f", ""),
            ("g", "[1, \"]\"], [2]"),
            ("h", "0 1"),
            ("i", "a\\\"b"),
            ("j", ""),
        ];
        assert_eq!(pairs(line).unwrap(), expected);
        assert_eq!(pairs("= = é=ü").unwrap(), [("", "="), ("é", "ü")]);
        for open in ["a=\"b", "a=\"b\\\"", "a='", "\"key", "a={b", "a=[[b]", "a=\"b\\", "a=\"\\é"] {
            assert!(pairs(open).is_err(), "{open}");
        }
    }
}
