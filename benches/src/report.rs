//! `RESULTS.md`: everything that was measured, in tables.

use crate::agreement::Agreement;
use crate::comparison::Comparison;
use crate::kernels::{Kernels, Profile, WorkKernels};
use crate::machine::Machine;
use crate::ours::Ours;
use crate::scale::Scale;
use crate::statistics::Spread;
use crate::store::Results;
use crate::table::markdown;
use crate::work::WORKS;

const NOTHING: &str = "–";

/// The page.
pub fn render(results: &Results) -> String {
    let mut parts = vec![
        "# Benchmarks\n\nRendered by `cargo xtask bench` from the JSON files beside this page. Machines are shared and noisy: the two \
         sides of a ratio are timed in turn, and the median over the rounds counts.\n"
            .to_owned(),
        machine(&results.machine),
    ];
    if !results.comparisons.is_empty() {
        parts.push(comparisons(&results.comparisons));
    }
    if !results.agreements.is_empty() {
        parts.push(agreements(&results.agreements));
    }
    parts.extend(results.ours.as_ref().map(ours));
    parts.extend(results.kernels.as_ref().map(kernels));
    parts.extend(results.scale.as_ref().map(scale));
    parts.join("\n")
}

fn machine(machine: &Machine) -> String {
    let lammps = machine.lammps.clone().unwrap_or_else(|| "none".to_owned());
    let row = |name: &str, value: String| vec![name.to_owned(), value];
    let rows = [
        row("processor", machine.processor.clone()),
        row("cores", machine.cores.to_string()),
        row("caches of a core", machine.caches.join(", ")),
        row("instruction sets", format!("{} (the last is used)", machine.instruction_sets.join(", "))),
        row("compiler", machine.compiler.clone()),
        row("LAMMPS", lammps),
        row("last run", machine.date.clone()),
    ];
    format!("## Machine\n\n{}", markdown(&["", ""], &rows))
}

fn comparisons(rows: &[Comparison]) -> String {
    let row = |row: &Comparison| {
        let spread = match (row.ratio_smallest, row.ratio_largest) {
            (Some(smallest), Some(largest)) => format!("{smallest:.2} … {largest:.2}"),
            _ => NOTHING.to_owned(),
        };
        let number = |value: Option<f64>, scale: f64| {
            value.map_or_else(|| NOTHING.to_owned(), |value| format!("{:.2}", value * scale))
        };
        let particles =
            if row.replicas > 1 { format!("{} × {}", row.replicas, row.particles) } else { row.particles.to_string() };
        vec![
            row.work.clone(),
            row.integrator.clone(),
            row.threads.to_string(),
            particles,
            number(Some(row.particle_steps_per_second), 1e-6),
            number(row.lammps_particle_steps_per_second, 1e-6),
            row.lammps_variant.clone().unwrap_or_else(|| NOTHING.to_owned()),
            number(row.ratio, 1.0),
            spread,
            row.rounds.to_string(),
        ]
    };
    let header =
        ["work", "integrator", "threads", "particles", "ours", "LAMMPS", "its best", "ratio", "spread", "rounds"];
    let titles: String = WORKS.iter().map(|work| format!("- `{}`: {}\n", work.name, work.title)).collect();
    let table = markdown(&header, &rows.iter().map(row).collect::<Vec<_>>());
    format!(
        "## Against LAMMPS\n\nMillions of particle-steps per second in double precision, and the ratio of ours to LAMMPS' best: on one \
         thread `plain` or the OpenMP package (`omp`); on two, two ranks (`mpi`) or `omp`. Both programs warm up before they are timed. \
         On two threads `lj-dpd` is split by replica: two systems side by side, all of whose steps count; LAMMPS may do the same \
         (`replicas`, two processes) if that is its best.\n\n{titles}\n{table}\n{}",
        measured(rows.iter().map(|row| (row.machine.as_str(), row.date.as_str())))
    )
}

fn agreements(rows: &[Agreement]) -> String {
    let row = |row: &Agreement| {
        vec![
            row.work.clone(),
            row.integrator.clone(),
            row.quantity.clone(),
            format!("{:.5} ± {:.5}", row.value, row.standard_error),
            format!("{:.5} ± {:.5}", row.lammps_value, row.lammps_standard_error),
            format!("{:.1}", row.z_score()),
            format!("{:.5}", row.allowed),
        ]
    };
    let header = ["work", "integrator", "quantity", "ours", "LAMMPS", "z", "allowed difference"];
    format!(
        "### The same physics\n\nMeans along the sampled run of each program, errors by blocking; a larger difference than the allowed \
         one stops the benchmark. Velocity Verlet is the same algorithm in both. ABOBA and LAMMPS' velocity Verlet differ at \
         order Δt², so z need not be small there. LAMMPS' pressure also holds friction, 0.2 % too much for Groot and Warren's \
         fluid, and noise: on the ideal fluid it is mostly noise.\n\n{}",
        markdown(&header, &rows.iter().map(row).collect::<Vec<_>>())
    )
}

fn ours(ours: &Ours) -> String {
    let rows: Vec<Vec<String>> = ours
        .ratios
        .iter()
        .map(|row| {
            vec![
                row.what.clone(),
                row.work.clone(),
                row.particles.to_string(),
                row.threads.map_or_else(|| NOTHING.to_owned(), |threads| threads.to_string()),
                format!("{:.3}", row.ratio.median),
                range(&row.ratio, 3),
                row.rounds.to_string(),
            ]
        })
        .collect();
    format!(
        "## Our own routes beside each other\n\nTime a step of the first over that of the second.\n\n{}\n{}",
        markdown(&["what", "work", "particles", "threads", "ratio", "spread", "rounds"], &rows),
        measured([(ours.machine.as_str(), ours.date.as_str())].into_iter())
    )
}

fn kernels(kernels: &Kernels) -> String {
    let mut text = "## Kernels\n\nOn one thread, over the pairs within the cutoff. Cycles are those of the core, whose frequency is measured \
                    beside each kernel.\n"
        .to_owned();
    for work in &kernels.works {
        text += &one_work(work);
    }
    format!("{text}\n{}", measured([(kernels.machine.as_str(), kernels.date.as_str())].into_iter()))
}

fn one_work(work: &WorkKernels) -> String {
    let rows: Vec<Vec<String>> = work
        .kernels
        .iter()
        .map(|row| {
            let (time, cycles) = (&row.nanoseconds_per_pair, &row.cycles_per_pair);
            vec![row.kernel.clone(), format!("{:.2}", time.median), range(time, 2), format!("{:.1}", cycles.median)]
        })
        .collect();
    let table = markdown(&["kernel", "ns a pair", "spread", "cycles a pair"], &rows);
    let profiles: String = work.profiles.iter().map(profile).collect();
    format!("\n### {}, {} particles, {} pairs\n\n{table}{profiles}", work.work, work.particles, work.pairs)
}

fn profile(profile: &Profile) -> String {
    let row = |phase: &crate::kernels::Phase| vec![phase.phase.clone(), format!("{:.1} %", 100.0 * phase.share)];
    format!(
        "\nA step of {}: {:.1} ns a particle, {:.3} lists; its parts, each as it takes alone:\n\n{}",
        profile.integrator,
        profile.nanoseconds_per_particle_step.median,
        profile.lists_per_step,
        markdown(&["phase", "share"], &profile.phases.iter().map(row).collect::<Vec<_>>())
    )
}

fn scale(scale: &Scale) -> String {
    let rows: Vec<Vec<String>> = scale
        .sizes
        .iter()
        .map(|size| {
            let bytes = size.bytes_per_particle().map_or_else(|| NOTHING.to_owned(), |bytes| format!("{bytes:.0}"));
            vec![
                size.threads.to_string(),
                size.particles.to_string(),
                format!("{:.1}", size.nanoseconds_per_particle_step.median),
                range(&size.nanoseconds_per_particle_step, 1),
                bytes,
            ]
        })
        .collect();
    let ratio = |threads: usize| {
        let text =
            |ratio| format!("- On {threads} thread(s), 10⁷ particles cost {ratio:.2} times as much each as 10⁵.\n");
        scale.ratio(threads).map(text)
    };
    let ratios: String = [1, 2].into_iter().filter_map(ratio).collect();
    format!(
        "## Scale\n\nThe Groot–Warren fluid, {}. Memory is the most that the whole process ever had.\n\n{}\n{ratios}\n{}",
        scale.integrator,
        markdown(&["threads", "particles", "ns a particle-step", "spread", "bytes a particle"], &rows),
        measured([(scale.machine.as_str(), scale.date.as_str())].into_iter())
    )
}

fn range(spread: &Spread, digits: usize) -> String {
    format!("{:.digits$} … {:.digits$}", spread.smallest, spread.largest)
}

/// Where and when, each place and day once.
fn measured<'a>(places: impl Iterator<Item = (&'a str, &'a str)>) -> String {
    let mut known: Vec<String> = places.map(|(machine, date)| format!("{machine}, {date}")).collect();
    known.sort();
    known.dedup();
    format!("*Measured on {}.*\n", known.join("; "))
}
