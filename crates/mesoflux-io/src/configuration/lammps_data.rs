//! LAMMPS data files: a header of counts and box, then sections of lines.
//!
//! `Masses`, `Atoms`, `Velocities`, `Bonds` and the labels of atom and bond types are read, sections of coefficients passed
//! over, all others refused. Particles are numbered by ascending id; image flags are checked and passed over.

use super::text::{self, Lines, MOST_KINDS, MOST_PARTICLES, shown};
use super::{Bond, Configuration, ConfigurationError, Motion, Named};
use mesoflux_core::vector::{Vector, ZERO};
use std::fmt::{Display, Formatter};

const SECTIONS_READ: [&str; 6] = ["Atom Type Labels", "Bond Type Labels", "Masses", "Atoms", "Velocities", "Bonds"];
/// Laws come from the input file, and there are no angles whose types could need labels.
const SECTIONS_PASSED_OVER: [&str; 17] = [
    "Pair Coeffs",
    "PairIJ Coeffs",
    "Bond Coeffs",
    "Angle Coeffs",
    "Dihedral Coeffs",
    "Improper Coeffs",
    "BondBond Coeffs",
    "BondAngle Coeffs",
    "MiddleBondTorsion Coeffs",
    "EndBondTorsion Coeffs",
    "AngleTorsion Coeffs",
    "AngleAngleTorsion Coeffs",
    "BondBond13 Coeffs",
    "AngleAngle Coeffs",
    "Angle Type Labels",
    "Dihedral Type Labels",
    "Improper Type Labels",
];
/// The atom styles that are read, and their columns.
const STYLES: [(&str, &[&str]); 7] = [
    ("atomic", &["id", "type", "x", "y", "z"]),
    ("bond", &["id", "molecule", "type", "x", "y", "z"]),
    ("angle", &["id", "molecule", "type", "x", "y", "z"]),
    ("molecular", &["id", "molecule", "type", "x", "y", "z"]),
    ("charge", &["id", "type", "q", "x", "y", "z"]),
    ("dpd", &["id", "type", "theta", "x", "y", "z"]),
    ("full", &["id", "molecule", "type", "q", "x", "y", "z"]),
];
/// Ids are numbers of 64 bits with a sign.
const LARGEST_ID: u64 = i64::MAX as u64;
/// Sides of the box in the header.
const BOUNDS: [[&str; 2]; 3] = [["xlo", "xhi"], ["ylo", "yhi"], ["zlo", "zhi"]];
/// The shortest lines of a particle ("1 1 0 0 0"), a velocity ("1 0 0 0") and a bond ("1 1 1 2") with their ends.
const SHORTEST_PARTICLE: usize = 10;
const SHORTEST_BOND: usize = 8;

/// Reads the particles in `text`; messages call it `name`.
///
/// # Errors
/// The first thing in the text that is wrong, with its line.
pub fn parse(name: &str, text: &[u8]) -> Result<Configuration, ConfigurationError> {
    let mut lines = Lines::new(name, text)?;
    // The first line is a comment, whatever it says.
    lines.next();
    let (header, mut title) = Header::read(&mut lines)?;
    let mut body = Body::new(&header);
    let mut titles: Vec<(&str, u64)> = Vec::new();
    while let Some(Title { name, style }) = title {
        if let Some((_, line)) = titles.iter().find(|(earlier, _)| *earlier == name) {
            return Err(lines.wrong(format!("section = {name}: must come once, and line {line} begins it already")));
        }
        titles.push((name, lines.number()));
        if matches!(name, "Velocities" | "Bonds") && body.ids.is_empty() {
            return Err(
                lines.wrong(format!("section = {name}: must come after section Atoms, because it names particles"))
            );
        }
        title = match name {
            "Atom Type Labels" => body.atom_types.read_labels(&mut lines, name)?,
            "Bond Type Labels" => body.bond_types.read_labels(&mut lines, name)?,
            "Masses" => body.read_masses(&mut lines)?,
            "Atoms" => body.read_atoms(&mut lines, style)?,
            "Velocities" => body.read_velocities(&mut lines)?,
            "Bonds" => body.read_bonds(&mut lines)?,
            _ if SECTIONS_PASSED_OVER.contains(&name) => pass_over(&mut lines),
            _ => {
                let (name, known) = (shown(name), SECTIONS_READ.join(", "));
                return Err(
                    lines.wrong(format!("section = {name}: must be one of {known}, or a section of coefficients"))
                );
            }
        };
    }
    for (section, promise) in [("Atoms", header.atoms), ("Bonds", header.bonds)] {
        if promise.count > 0 && !titles.iter().any(|(title, _)| *title == section) {
            let reason =
                format!("section {section} is missing: must be there, because {promise}, but the file ends here");
            return Err(lines.wrong(reason));
        }
    }
    Ok(body.finish())
}

/// A number that the header gives, and where.
#[derive(Clone, Copy)]
struct Promise {
    what: &'static str,
    count: u64,
    line: u64,
}

impl Display for Promise {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self { what, count: 0, .. } => write!(formatter, "the header promises no {what}"),
            Self { what, count, line } => write!(formatter, "line {line} says \"{count} {what}\""),
        }
    }
}

/// The line that begins a section, and the atom style in its comment.
struct Title<'a> {
    name: &'a str,
    style: Option<&'a str>,
}

impl<'a> Title<'a> {
    fn of(line: &'a str) -> Self {
        let (_, comment) = line.split_once('#').unwrap_or_default();
        Self { name: content(line), style: comment.split_ascii_whitespace().next() }
    }
}

/// A line without its comment.
fn content(line: &str) -> &str {
    line.split_once('#').map_or(line, |(content, _)| content).trim_ascii()
}

fn is_title(content: &str) -> bool {
    begins_with_letter(content) && (SECTIONS_READ.contains(&content) || SECTIONS_PASSED_OVER.contains(&content))
}

fn begins_with_letter(content: &str) -> bool {
    content.starts_with(|character: char| character.is_ascii_alphabetic())
}

/// The lines of a section, as many as are promised; `each` reads one, given its words and its number. Returns the next title.
fn read_section<'a>(
    lines: &mut Lines<'a>,
    name: &str,
    promise: Promise,
    mut each: impl FnMut(&[&'a str], u64) -> Result<(), String>,
) -> Result<Option<Title<'a>>, ConfigurationError> {
    let mut words = Vec::new();
    for found in 0..promise.count {
        let line = lines.find(|line| !content(line).is_empty()).map(content);
        let end = match line {
            None => "the file ends",
            Some(line) if is_title(line) => "another section begins",
            Some(line) => {
                words.clear();
                words.extend(line.split_ascii_whitespace());
                each(&words, lines.number()).map_err(|reason| lines.wrong(reason))?;
                continue;
            }
        };
        let count = promise.count;
        let reason = format!("lines of section {name} = {found} where {end}: must be {count}, because {promise}");
        return Err(lines.wrong(reason));
    }
    let Some(line) = lines.find(|line| !content(line).is_empty()) else {
        return Ok(None);
    };
    if begins_with_letter(line) {
        return Ok(Some(Title::of(line)));
    }
    let line = shown(line);
    Err(lines.wrong(format!("surplus line = \"{line}\": must not be in section {name}, because {promise}")))
}

/// Passes over the lines of a section, however many they are. Returns the next title.
fn pass_over<'a>(lines: &mut Lines<'a>) -> Option<Title<'a>> {
    let (mut begun, mut after_blank) = (false, false);
    let next = lines.find(|line| {
        let content = content(line);
        if content.is_empty() {
            after_blank = begun;
            return false;
        }
        // Coefficients may begin with the label of a type, but then no blank line comes before them.
        let title = is_title(content) || after_blank && begins_with_letter(content);
        (begun, after_blank) = (true, false);
        title
    });
    next.map(Title::of)
}

/// That a line has as many words as it must.
fn expect_words(words: &[&str], columns: &str) -> Result<(), String> {
    let expected = columns.split(' ').count();
    if words.len() == expected {
        return Ok(());
    }
    Err(format!("columns = {}: must be {expected} ({columns})", words.len()))
}

/// What the header says.
struct Header {
    atoms: Promise,
    bonds: Promise,
    atom_types: Promise,
    bond_types: Promise,
    corner: Vector,
    sides: Vector,
}

/// The header as far as it is read.
#[derive(Default)]
struct Entries {
    atoms: Option<Promise>,
    bonds: Option<Promise>,
    atom_types: Option<Promise>,
    bond_types: Option<Promise>,
    /// lo and hi of each axis, and their line.
    bounds: [Option<([f64; 2], u64)>; 3],
}

impl Header {
    /// Reads the header, and the title of the first section.
    fn read<'a>(lines: &mut Lines<'a>) -> Result<(Self, Option<Title<'a>>), ConfigurationError> {
        let mut entries = Entries::default();
        let mut words = Vec::new();
        let mut title = None;
        while let Some(line) = lines.find(|line| !content(line).is_empty()) {
            let content = content(line);
            if is_title(content) {
                title = Some(Title::of(line));
                break;
            }
            words.clear();
            words.extend(content.split_ascii_whitespace());
            let known = entries.add(&words, lines.number()).map_err(|reason| lines.wrong(reason))?;
            if !known {
                return Err(lines.wrong(format!(
                    "line = \"{}\": must be a line of the header, such as \"100 atoms\" or \"0 10 xlo xhi\", or the title of \
                     a section, such as \"Atoms\"",
                    shown(line)
                )));
            }
        }
        let header = entries.finish().map_err(|reason| lines.wrong(reason))?;
        Ok((header, title))
    }
}

impl Entries {
    /// Adds the words of a line; `false` where they are no line of the header.
    fn add(&mut self, words: &[&str], line: u64) -> Result<bool, String> {
        let once = |entry: &mut Option<Promise>, what, word, low, high| {
            if let Some(Promise { line, .. }) = entry {
                return Err(format!("{what} = {}: must be given once, and line {line} gives it already", shown(word)));
            }
            *entry = Some(Promise { what, count: text::integer(what, word, low..=high)?, line });
            Ok(())
        };
        match *words {
            [count, "atoms"] => once(&mut self.atoms, "atoms", count, 1, MOST_PARTICLES)?,
            [count, "bonds"] => once(&mut self.bonds, "bonds", count, 0, LARGEST_ID)?,
            [count, "atom", "types"] => once(&mut self.atom_types, "atom types", count, 1, MOST_KINDS)?,
            [count, "bond", "types"] => once(&mut self.bond_types, "bond types", count, 0, MOST_KINDS)?,
            [
                count,
                what @ ("angles" | "dihedrals" | "impropers" | "crossterms" | "ellipsoids" | "lines" | "triangles"
                | "bodies"),
            ] => {
                if text::integer(what, count, 0..=LARGEST_ID)? != 0 {
                    return Err(format!("{what} = {count}: must be 0, because mesoflux has none and would lose them"));
                }
            }
            [count, what @ ("angle" | "dihedral" | "improper"), "types"] => {
                text::integer(format_args!("{what} types"), count, 0..=LARGEST_ID)?;
            }
            [count, "extra", "bond" | "angle" | "dihedral" | "improper" | "special", "per", "atom"] => {
                text::integer("extra entries per atom", count, 0..=LARGEST_ID)?;
            }
            [low, high, low_name, high_name] if BOUNDS.contains(&[low_name, high_name]) => {
                return self.add_bounds([low, high], [low_name, high_name], line).map(|()| true);
            }
            [xy, xz, yz, "xy", "xz", "yz"] => {
                for (name, word) in [("xy", xy), ("xz", xz), ("yz", yz)] {
                    if text::number(name, word)? != 0.0 {
                        return Err(format!("{name} = {word}: must be 0, because the box is orthorhombic"));
                    }
                }
            }
            [.., name @ ("avec" | "bvec" | "cvec")] | [.., name @ "abc", "origin"] => {
                return Err(format!(
                    "box = a general triclinic one by {name}: must be orthorhombic, as in \"0 10 xlo xhi\""
                ));
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn add_bounds(&mut self, words: [&str; 2], names: [&str; 2], line: u64) -> Result<(), String> {
        let [low_name, high_name] = names;
        let entry = self.bounds.iter_mut().zip(BOUNDS).find(|(_, bounds)| *bounds == names);
        let Some((entry, _)) = entry else { return Ok(()) };
        if let Some((_, earlier)) = entry {
            let words = shown(&words.join(" "));
            return Err(format!(
                "{low_name} {high_name} = {words}: must be given once, and line {earlier} gives it already"
            ));
        }
        let low = text::number(low_name, words[0])?;
        let high = text::number(high_name, words[1])?;
        if !(high > low) {
            return Err(format!("{high_name} = {}: must be greater than {low_name} = {}", words[1], words[0]));
        }
        if !(high - low).is_finite() {
            return Err(format!("{high_name} - {low_name} = {}: must be finite", high - low));
        }
        *entry = Some(([low, high], line));
        Ok(())
    }

    fn finish(self) -> Result<Header, String> {
        let missing = |what: &str, example: &str| {
            format!(
                "{what} is missing: must stand between line 1, a comment, and the first section, as in \"{example}\""
            )
        };
        let atoms = self.atoms.ok_or_else(|| missing("the number of atoms", "100 atoms"))?;
        let atom_types = self.atom_types.ok_or_else(|| missing("the number of atom types", "2 atom types"))?;
        let (mut corner, mut sides) = (ZERO, ZERO);
        for (axis, [low_name, high_name]) in BOUNDS.into_iter().enumerate() {
            let Some(([low, high], _)) = self.bounds[axis] else {
                return Err(missing(&format!("{low_name} {high_name}"), &format!("0 10 {low_name} {high_name}")));
            };
            corner[axis] = low;
            sides[axis] = high - low;
        }
        let bonds = self.bonds.unwrap_or(Promise { what: "bonds", count: 0, line: atoms.line });
        let bond_types = match self.bond_types {
            Some(types) if types.count > 0 || bonds.count == 0 => types,
            None if bonds.count == 0 => Promise { what: "bond types", count: 0, line: atoms.line },
            types => {
                let found = types.map_or("the number of bond types is missing".to_owned(), |types| {
                    format!("bond types = 0 in line {}", types.line)
                });
                return Err(format!("{found}: must be at least 1, because {bonds}"));
            }
        };
        Ok(Header { atoms, bonds, atom_types, bond_types, corner, sides })
    }
}

/// The types of atoms or of bonds.
struct Types<'a> {
    /// How many the header promises, and where.
    promise: Promise,
    /// By type, its label and the line of that.
    labels: Vec<Option<(&'a str, u64)>>,
    /// By type, the line where it is first used.
    first_used: Vec<Option<u64>>,
}

impl<'a> Types<'a> {
    fn new(promise: Promise) -> Self {
        let count = promise.count as usize;
        Self { promise, labels: vec![None; count], first_used: vec![None; count] }
    }

    /// The type, from 0, that a word names by its number.
    fn find_number(&self, word: &str) -> Result<usize, String> {
        let number = text::integer("type", word, 1..=self.promise.count);
        number.map(|number| number as usize - 1).map_err(|reason| format!("{reason}, because {}", self.promise))
    }

    /// The type, from 0, that a word names by its number or its label.
    fn find(&self, word: &str) -> Result<usize, String> {
        if begins_with_digit(word) || self.labels.iter().all(Option::is_none) {
            return self.find_number(word);
        }
        let label = self.labels.iter().position(|label| label.is_some_and(|(label, _)| label == word));
        label.ok_or_else(|| {
            let (word, count) = (shown(word), self.promise.count);
            format!("type = {word}: must be a whole number from 1 to {count}, or a label from an earlier section")
        })
    }

    /// The type that a word names in a line where it is used.
    fn used(&mut self, word: &str, line: u64) -> Result<usize, String> {
        let kind = self.find(word)?;
        self.first_used[kind].get_or_insert(line);
        Ok(kind)
    }

    fn read_labels(&mut self, lines: &mut Lines<'a>, section: &str) -> Result<Option<Title<'a>>, ConfigurationError> {
        read_section(lines, section, self.promise, |words, line| {
            expect_words(words, "type label")?;
            let kind = self.find_number(words[0])?;
            let label = words[1];
            if begins_with_digit(label) {
                return Err(format!("label = {}: must not begin with a digit, as numbers of types do", shown(label)));
            }
            if let Some((_, earlier)) = self.labels.iter().flatten().find(|(earlier, _)| *earlier == label) {
                let label = shown(label);
                return Err(format!("label = {label}: must be of one type only, and line {earlier} has it already"));
            }
            match self.labels[kind].replace((label, line)) {
                None => Ok(()),
                Some((_, earlier)) => {
                    Err(format!("type = {}: must have one label, and line {earlier} gives it one already", kind + 1))
                }
            }
        })
    }

    /// The names of the types; each has the line that `preferred` knows, or the one where it is first used, or the header's.
    fn finish(&self, preferred: impl Fn(usize) -> Option<u64>) -> Vec<Named> {
        let name =
            |kind: usize| self.labels[kind].map_or_else(|| (kind + 1).to_string(), |(label, _)| label.to_owned());
        let line = |kind: usize| preferred(kind).or(self.first_used[kind]).unwrap_or(self.promise.line);
        (0..self.labels.len()).map(|kind| Named { name: name(kind), line: line(kind) }).collect()
    }
}

fn begins_with_digit(word: &str) -> bool {
    word.starts_with(|character: char| character.is_ascii_digit())
}

/// Where an atom style has its columns.
struct Layout {
    name: &'static str,
    columns: &'static [&'static str],
    molecule: Option<usize>,
    kind: usize,
    charge: Option<usize>,
    temperature: Option<usize>,
    position: usize,
}

impl Layout {
    fn of((name, columns): (&'static str, &'static [&'static str])) -> Self {
        let place = |wanted: &str| columns.iter().position(|column| *column == wanted);
        Self {
            name,
            columns,
            molecule: place("molecule"),
            kind: place("type").unwrap_or(1),
            charge: place("q"),
            temperature: place("theta"),
            position: columns.len() - 3,
        }
    }

    /// The layout of a style that the file names.
    fn named(style: &str) -> Result<Self, String> {
        STYLES.into_iter().find(|(name, _)| *name == style).map(Self::of).ok_or_else(|| {
            let known = STYLES.map(|(name, _)| name).join(", ");
            format!("atom style = {}: must be one of {known}, as in \"Atoms # bond\"", shown(style))
        })
    }

    /// The layout that lines of so many columns must have where no style is named.
    fn guessed(columns: usize, bonds: Promise) -> Result<Self, String> {
        match columns {
            5 | 8 => Self::named("atomic"),
            7 | 10 => Self::named("full"),
            6 | 9 if bonds.count > 0 => Self::named("bond"),
            6 | 9 => Err(format!(
                "atom style of {columns} columns = bond, charge or dpd: must be named in the title of the section, as in \
                 \"Atoms # bond\""
            )),
            _ => Err(format!("columns = {columns}: must be 5, 6 or 7, and 3 more where there are image flags")),
        }
    }
}

/// What the sections say.
struct Body<'a> {
    header: &'a Header,
    atom_types: Types<'a>,
    bond_types: Types<'a>,
    /// By type, the mass and its line.
    masses: Vec<Option<(f64, u64)>>,
    /// Ids ascending, each with the place of its line in the section; empty before the section.
    ids: Vec<(u64, u32)>,
    kinds: Vec<u32>,
    positions: Vec<Vector>,
    velocities: Option<Vec<Vector>>,
    bonds: Vec<Bond>,
}

impl<'a> Body<'a> {
    fn new(header: &'a Header) -> Self {
        Self {
            header,
            atom_types: Types::new(header.atom_types),
            bond_types: Types::new(header.bond_types),
            masses: vec![None; header.atom_types.count as usize],
            ids: Vec::new(),
            kinds: Vec::new(),
            positions: Vec::new(),
            velocities: None,
            bonds: Vec::new(),
        }
    }

    fn read_masses(&mut self, lines: &mut Lines<'a>) -> Result<Option<Title<'a>>, ConfigurationError> {
        read_section(lines, "Masses", self.header.atom_types, |words, line| {
            expect_words(words, "type mass")?;
            let kind = self.atom_types.find(words[0])?;
            let mass = text::positive("mass", words[1])?;
            match self.masses[kind].replace((mass, line)) {
                None => Ok(()),
                Some((_, earlier)) => Err(format!(
                    "type = {}: must have one mass, and line {earlier} gives it one already",
                    shown(words[0])
                )),
            }
        })
    }

    fn read_atoms(
        &mut self,
        lines: &mut Lines<'a>,
        style: Option<&str>,
    ) -> Result<Option<Title<'a>>, ConfigurationError> {
        let header = self.header;
        let room = lines.room(header.atoms.count, SHORTEST_PARTICLE);
        self.ids.reserve_exact(room);
        self.kinds.reserve_exact(room);
        self.positions.reserve_exact(room);
        let mut layout = style.map(Layout::named).transpose().map_err(|reason| lines.wrong(reason))?;
        let begin = lines.clone();
        let title = read_section(lines, "Atoms", header.atoms, |words, line| {
            let layout = match &mut layout {
                Some(layout) => layout,
                none => none.insert(Layout::guessed(words.len(), header.bonds)?),
            };
            self.add_atom(words, layout, line)
        })?;
        self.sort_atoms(&begin)?;
        Ok(title)
    }

    fn add_atom(&mut self, words: &[&str], layout: &Layout, line: u64) -> Result<(), String> {
        let width = layout.columns.len();
        if words.len() != width && words.len() != width + 3 {
            return Err(format!(
                "columns = {}: must be {width} ({}) or {} (with three image flags) for atom style {}",
                words.len(),
                layout.columns.join(" "),
                width + 3,
                layout.name
            ));
        }
        let id = text::integer("id", words[0], 1..=LARGEST_ID)?;
        if let Some(column) = layout.molecule {
            text::integer("molecule", words[column], 0..=LARGEST_ID)?;
        }
        let kind = self.atom_types.used(words[layout.kind], line)?;
        if let Some(column) = layout.charge
            && text::number("charge", words[column])? != 0.0
        {
            return Err(format!("charge = {}: must be 0, because mesoflux has no charges", shown(words[column])));
        }
        if let Some(column) = layout.temperature {
            text::number("internal temperature", words[column])?;
        }
        let position = text::position(&words[layout.position..width], self.header.corner)?;
        for word in &words[width..] {
            if word.parse::<i64>().is_err() {
                return Err(format!("image flag = {}: must be a whole number of 64 bits", shown(word)));
            }
        }
        self.ids.push((id, self.ids.len() as u32));
        self.kinds.push(kind as u32);
        self.positions.push(position);
        Ok(())
    }

    /// Brings the particles into the order of their ids; `begin` is where their section begins.
    fn sort_atoms(&mut self, begin: &Lines<'a>) -> Result<(), ConfigurationError> {
        if self.ids.is_sorted_by(|first, second| first.0 < second.0) {
            return Ok(());
        }
        self.ids.sort_unstable();
        let again = self.ids.windows(2).filter(|pair| pair[0].0 == pair[1].0).map(|pair| (pair[1].1, pair[0]));
        if let Some((place, (id, earlier))) = again.min_by_key(|(place, _)| *place) {
            // Lines of particles are not kept, but a file that is refused may be read twice.
            let line_of = |place: u32| {
                let mut lines = begin.clone();
                lines.by_ref().filter(|line| !content(line).is_empty()).nth(place as usize);
                lines
            };
            let earlier = line_of(earlier).number();
            return Err(line_of(place)
                .wrong(format!("id = {id}: must be of one particle only, and line {earlier} gives it to another")));
        }
        self.kinds = self.ids.iter().map(|(_, place)| self.kinds[*place as usize]).collect();
        self.positions = self.ids.iter().map(|(_, place)| self.positions[*place as usize]).collect();
        Ok(())
    }

    fn read_velocities(&mut self, lines: &mut Lines<'a>) -> Result<Option<Title<'a>>, ConfigurationError> {
        let mut velocities = vec![ZERO; self.ids.len()];
        let mut given = vec![false; self.ids.len()];
        let title = read_section(lines, "Velocities", self.header.atoms, |words, _| {
            expect_words(words, "id v_x v_y v_z")?;
            let particle = find_particle(&self.ids, "id", words[0])?;
            if std::mem::replace(&mut given[particle], true) {
                return Err(format!(
                    "id = {}: must have one velocity, and a line before gives it one already",
                    words[0]
                ));
            }
            velocities[particle] = text::vector(["v_x", "v_y", "v_z"], &words[1..])?;
            Ok(())
        })?;
        self.velocities = Some(velocities);
        Ok(title)
    }

    fn read_bonds(&mut self, lines: &mut Lines<'a>) -> Result<Option<Title<'a>>, ConfigurationError> {
        self.bonds.reserve_exact(lines.room(self.header.bonds.count, SHORTEST_BOND));
        read_section(lines, "Bonds", self.header.bonds, |words, line| {
            expect_words(words, "bond type particle particle")?;
            text::integer("bond", words[0], 1..=LARGEST_ID)?;
            let kind = self.bond_types.used(words[1], line)? as u32;
            let first = find_particle(&self.ids, "first particle of the bond", words[2])? as u64;
            let second = find_particle(&self.ids, "second particle of the bond", words[3])? as u64;
            if first == second {
                let word = words[3];
                return Err(format!("second particle of the bond = {word}: must be another one than the first"));
            }
            self.bonds.push(Bond { kind, first, second });
            Ok(())
        })
    }

    fn finish(self) -> Configuration {
        let lines = |kind: usize| self.masses[kind].map(|(_, line)| line);
        let labels = |kind: usize| self.bond_types.labels[kind].map(|(_, line)| line);
        Configuration {
            sides: self.header.sides,
            species: self.atom_types.finish(lines),
            bond_kinds: self.bond_types.finish(labels),
            kinds: self.kinds,
            positions: self.positions,
            motion: self.velocities.map(Motion::Velocities),
            masses: self.masses.iter().map(|mass| mass.map(|(mass, _)| mass)).collect(),
            bonds: self.bonds,
        }
    }
}

/// The number of the particle whose id a word says.
fn find_particle(ids: &[(u64, u32)], what: &str, word: &str) -> Result<usize, String> {
    let id = text::integer(what, word, 1..=LARGEST_ID)?;
    // Most files have every id from the first on.
    let guess = ids.first().and_then(|(first, _)| usize::try_from(id.checked_sub(*first)?).ok());
    if let Some(guess) = guess.filter(|guess| ids.get(*guess).is_some_and(|(found, _)| *found == id)) {
        return Ok(guess);
    }
    ids.binary_search_by_key(&id, |(id, _)| *id)
        .map_err(|_| format!("{what} = {id}: must be the id of a particle in section Atoms"))
}
