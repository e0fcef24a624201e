//! How a statistical test is judged: by its z-scores with seed 1, or by the distribution of those of many seeds.

use mesoflux_analysis::{normal_cdf, standard_normal_summary};

/// How many seeds the tests run: the environment variable `MESOFLUX_SEEDS`, else one.
pub fn seeds() -> u64 {
    std::env::var("MESOFLUX_SEEDS").map_or(1, |text| text.parse().unwrap())
}

/// Asserts |z| ≤ 3 for every z-score of seed 1.
///
/// With `MESOFLUX_SEEDS=n`, n > 1, asserts instead that the z-scores of the seeds 1 to n look like draws of N(0, 1): their
/// mean, their variance and the largest of them. The scores of one seed must be independent.
pub fn check_scores(scores: impl Fn(u64) -> Vec<f64>) {
    let seeds = seeds();
    if seeds <= 1 {
        let scores = scores(1);
        println!("z = {scores:.2?}");
        assert!(scores.iter().all(|z| z.abs() <= 3.0), "z = {scores:.2?}");
        return;
    }
    let scores: Vec<f64> = (1..=seeds).flat_map(scores).collect();
    let summary = standard_normal_summary(&scores).unwrap();
    println!("{summary:#?}");
    let chances =
        [("mean", summary.mean_p_value), ("variance", summary.variance_p_value), ("largest", summary.largest_p_value)];
    for (what, chance) in chances {
        assert!(chance > 0.001, "{what} of the z-scores: {summary:#?}");
    }
}

/// The z-score that a p-value stands for: standard normal if the p-value is uniform. Below p = 1e-15, −8 or so.
pub fn probit(p: f64) -> f64 {
    let (mut low, mut high) = (-8.0, 8.0);
    while high - low > 1e-12 {
        let middle = 0.5 * (low + high);
        if normal_cdf(middle) < p {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}
