//! The operations that expressions are made of.

use crate::elementary::{absolute, exp, hyperbolic_tangent, logarithm, real_power, sine_ahead, square_root};
use crate::lanes::Real;

/// A function of one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Unary {
    /// −x.
    Negate,
    /// |x|.
    Absolute,
    /// √x.
    SquareRoot,
    /// eˣ.
    Exponential,
    /// ln x.
    Logarithm,
    /// sin x.
    Sine,
    /// cos x.
    Cosine,
    /// tanh x.
    HyperbolicTangent,
}

/// A function of two numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Binary {
    /// x + y.
    Add,
    /// x − y.
    Subtract,
    /// x y.
    Multiply,
    /// x/y.
    Divide,
    /// xʸ for x ≥ 0.
    Power,
    /// The smaller.
    Minimum,
    /// The larger.
    Maximum,
    /// 1 where x < y, else 0.
    Below,
}

impl Unary {
    /// Its value.
    #[inline(always)]
    pub fn of<R: Real>(self, x: R) -> R {
        match self {
            Self::Negate => -x,
            Self::Absolute => absolute(x),
            Self::SquareRoot => square_root(x),
            Self::Exponential => exp(x),
            Self::Logarithm => logarithm(x),
            Self::Sine | Self::Cosine => sine_ahead(x, u64::from(self == Self::Cosine)),
            Self::HyperbolicTangent => hyperbolic_tangent(x),
        }
    }
}

impl Binary {
    /// Its value.
    #[inline(always)]
    pub fn of<R: Real>(self, x: R, y: R) -> R {
        match self {
            Self::Add => x + y,
            Self::Subtract => x - y,
            Self::Multiply => x * y,
            Self::Divide => x / y,
            Self::Power => real_power(x, y),
            Self::Minimum => R::select(y.below(x), y, x),
            Self::Maximum => R::select(x.below(y), y, x),
            Self::Below => R::select(x.below(y), R::splat(1.0), R::splat(0.0)),
        }
    }
}

/// `yes` where the condition is not zero, else `no`.
#[inline(always)]
pub fn choose<R: Real>(condition: R, yes: R, no: R) -> R {
    R::select(R::splat(0.0).below(absolute(condition)), yes, no)
}
