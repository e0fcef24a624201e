//! Every instruction set against single numbers, to the bit.

use super::*;
use crate::elementary::{exp, exp_minus_one, inverse_sqrt, ln, nearest_integer, sin_half_pi};
use crate::noise::{NoiseKey, Purpose};

/// Numbers of many sizes and both signs.
fn numbers(seed: u64) -> [f64; WIDTH] {
    let draw = NoiseKey::new(&[seed]).draw(Purpose::Start, 0, 0);
    std::array::from_fn(|k| draw.gaussian(k as u64, 0) * 10f64.powi((draw.uniform(k as u64, 1) * 12.0) as i32 - 6))
}

/// Every function and every operation of `Real`, on eight numbers.
struct Functions([f64; WIDTH], [f64; WIDTH]);

fn functions<R: Real>(a: R, b: R) -> [R; 13] {
    let small = b * R::splat(1e-6);
    let positive = a.mul_add(a, R::splat(1e-9));
    let one = R::select(a.below(b), sin_half_pi(R::splat(0.25)), sin_half_pi(R::splat(-0.75)));
    let mixed =
        R::from_bits((a.to_bits().low_product(b.to_bits()) & R::Bits::splat((1 << 52) - 1)).plus(one.to_bits()));
    let shifted = (a.to_bits().shift_up::<20>() ^ b.to_bits().shift_down::<32>()) | R::Bits::splat(1);
    let bounded = R::from_bits((shifted & R::Bits::splat((1 << 52) - 1)) | R::Bits::splat(1023 << 52));
    [
        (a + b) * (a - b),
        a / b,
        -a.mul_add(b, R::splat(0.1)),
        exp(small),
        exp_minus_one(small),
        ln(positive),
        positive.sqrt(),
        inverse_sqrt(positive),
        nearest_integer(a),
        one,
        mixed,
        bounded,
        R::from_bits(a.to_bits().minus(R::Bits::splat(12_345))),
    ]
}

impl Kernel for Functions {
    type Output = [[f64; WIDTH]; 26];

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let (a, b) = (L::load(&self.0), L::load(&self.1));
        let (once, twice) = (functions(a, b), functions(Twice(a, b), Twice(b, a)));
        let mut results = [[0.0; WIDTH]; 26];
        for k in 0..13 {
            once[k].store(&mut results[k]);
            twice[k].1.store(&mut results[13 + k]);
        }
        results
    }
}

#[test]
fn every_set_gives_the_bits_of_single_numbers() {
    for seed in 0..200 {
        let (a, b) = (numbers(seed), numbers(seed + 1000));
        for set in InstructionSet::available() {
            let results = set.run(Functions(a, b));
            for lane in 0..WIDTH {
                let expected = functions(a[lane], b[lane]).into_iter().chain(functions(b[lane], a[lane]));
                for (k, expected) in expected.enumerate() {
                    let found = results[k][lane];
                    assert_eq!(found.to_bits(), expected.to_bits(), "{set:?}, function {k}: {found} for {expected}");
                }
            }
        }
    }
}

/// What moves numbers about: rows, gathers, sums, kinds, sorted words, and operations on a row.
struct Moves<'a> {
    column: &'a [Row],
    places: [u32; WIDTH],
    kinds: [u16; WIDTH],
}

#[derive(Debug, PartialEq)]
struct Moved {
    loaded: [[f64; WIDTH]; 4],
    rows: [Row; WIDTH],
    sum: f64,
    chosen: [f64; WIDTH],
    sorted: [[f64; WIDTH]; 2],
    row: Row,
    product: f64,
}

impl Kernel for Moves<'_> {
    type Output = Moved;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Moved {
        let mut moved = Moved {
            loaded: [[0.0; WIDTH]; 4],
            rows: [Row::default(); WIDTH],
            sum: 0.0,
            chosen: [0.0; WIDTH],
            sorted: [[0.0; WIDTH]; 2],
            row: Row::default(),
            product: 0.0,
        };
        // SAFETY: the places are below the column's length.
        let [x, y, z, w] = unsafe { L::load_rows(self.column.as_ptr(), &self.places) };
        x.store(&mut moved.loaded[0]);
        y.store(&mut moved.loaded[1]);
        z.store(&mut moved.loaded[2]);
        w.store(&mut moved.loaded[3]);
        L::rows([x, y, z], &mut moved.rows);
        moved.sum = x.sum();
        L::select(L::of_kind(&self.kinds, 7), x, y).store(&mut moved.chosen);
        let zero = L::splat(0.0);
        let [low, high] =
            L::sort_words(x.to_bits() & L::Bits::splat(u64::MAX >> 1), y.to_bits() & L::Bits::splat(u64::MAX >> 1));
        (L::from_bits(low) + zero).store(&mut moved.sorted[0]);
        (L::from_bits(high) + zero).store(&mut moved.sorted[1]);
        // SAFETY: there are these rows.
        unsafe {
            let (a, b) = (L::Row::load(&raw const self.column[0]), L::Row::load(&raw const self.column[1]));
            moved.product = a.dot(b);
            a.add(b).subtract(a.add_scaled(1.7, b)).store(&raw mut moved.row);
        }
        moved
    }
}

#[test]
fn rows_kinds_and_words_go_where_they_should_in_every_set() {
    let column: Vec<Row> = (0..40).map(|k| Row(std::array::from_fn(|c| numbers(k)[c]))).collect();
    let places = [3, 39, 0, 17, 17, 8, 1, 22];
    let kinds = [7, 0, 7, 7, 1, 263, 7, 0];
    let expected_rows = places.map(|place| column[place as usize]);
    for set in InstructionSet::available() {
        let moved = set.run(Moves { column: &column, places, kinds });
        for lane in 0..WIDTH {
            let Row([x, y, z, w]) = expected_rows[lane];
            assert_eq!([0, 1, 2, 3].map(|c: usize| moved.loaded[c][lane]), [x, y, z, w], "{set:?}");
            assert_eq!(moved.rows[lane], Row([x, y, z, 0.0]), "{set:?}");
            assert_eq!(moved.chosen[lane], if kinds[lane] == 7 { x } else { y }, "{set:?}");
            let (x, y) = (x.abs(), y.abs());
            assert_eq!([moved.sorted[0][lane], moved.sorted[1][lane]], [x.min(y), x.max(y)], "{set:?}");
        }
        assert_eq!(moved, InstructionSet::Portable.run(Moves { column: &column, places, kinds }), "{set:?}");
    }
}

/// A search among sixteen points.
struct Near([f32; 3], [[f32; SEARCH_WIDTH]; 3], [u32; SEARCH_WIDTH]);

/// Where the rectangle across the first axis lies.
const LOW: [f32; 2] = [0.1, 0.3];
const HIGH: [f32; 2] = [0.4, 0.5];

impl Kernel for Near {
    type Output = ([u32; 2], [u32; SEARCH_WIDTH], [[f32; SEARCH_WIDTH]; 3]);

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let candidates = L::Candidates::load(&self.2, [&self.1[0], &self.1[1], &self.1[2]]);
        let mask = candidates.near(self.0, 1.0);
        let mut packed = [0; SEARCH_WIDTH];
        candidates.compress(mask, &mut packed);
        let mut coordinates = [[0.0; SEARCH_WIDTH]; 3];
        let [x, y, z] = &mut coordinates;
        candidates.compress_coordinates(mask, [x, y, z]);
        ([mask, candidates.near_rectangle(LOW, HIGH, 0.3)], packed, coordinates)
    }
}

#[test]
fn every_set_finds_the_same_points_and_packs_them_in_order() {
    let draw = NoiseKey::new(&[5]).draw(Purpose::Start, 0, 0);
    for trial in 0..500 {
        let number = |k: u64| (3.0 * draw.uniform(trial, k) - 1.0) as f32;
        let mut others: [[f32; SEARCH_WIDTH]; 3] =
            std::array::from_fn(|axis| std::array::from_fn(|k| number((axis * SEARCH_WIDTH + k) as u64)));
        others[0][11] = f32::NAN;
        let point = [0.5, 0.4, 0.6];
        let names = std::array::from_fn(|k| 100 + k as u32);
        let near = |k: usize| (0..3).map(|axis| (point[axis] - others[axis][k]).powi(2)).sum::<f32>() < 1.0;
        let expected: Vec<u32> = (0..SEARCH_WIDTH).filter(|&k| near(k)).map(|k| names[k]).collect();
        let square = |axis: usize, k: usize| {
            let x = others[1 + axis][k];
            (x - x.clamp(LOW[axis], HIGH[axis])).powi(2)
        };
        let near_rectangle =
            (0..SEARCH_WIDTH).fold(0, |mask, k| mask | u32::from(square(0, k) + square(1, k) < 0.3) << k);
        for set in InstructionSet::available() {
            let ([mask, beside], packed, coordinates) = set.run(Near(point, others, names));
            assert_eq!(mask.count_ones() as usize, expected.len(), "{set:?}");
            assert_eq!(&packed[..expected.len()], &expected[..], "{set:?}");
            assert_eq!(beside, near_rectangle, "{set:?}");
            for (to, from) in coordinates.iter().zip(&others) {
                let expected: Vec<f32> = (0..SEARCH_WIDTH).filter(|&k| near(k)).map(|k| from[k]).collect();
                assert_eq!(&to[..expected.len()], &expected[..], "{set:?}");
            }
        }
    }
}
