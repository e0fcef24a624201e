//! Values that need a reader of their own: a law or "none", one number or several, the three sides of a box.

use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserialize, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Unexpected, Visitor};
use serde::ser::{Serialize, Serializer};
use std::fmt;
use std::marker::PhantomData;

/// Reads a law, or the word "none".
#[allow(clippy::option_option, reason = "the field is one: left out, switched off, given")]
pub(super) fn deserialize<'de, L: Deserialize<'de>, D: Deserializer<'de>>(
    input: D,
) -> Result<Option<Option<L>>, D::Error> {
    struct LawOrNone<L>(PhantomData<L>);

    impl<'de, L: Deserialize<'de>> Visitor<'de> for LawOrNone<L> {
        type Value = Option<L>;

        fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
            f.write_str("a law such as `NAME = { … }`, or \"none\"")
        }

        fn visit_str<E: Error>(self, word: &str) -> Result<Self::Value, E> {
            if word == "none" { Ok(None) } else { Err(E::invalid_value(Unexpected::Str(word), &self)) }
        }

        fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
            let law = L::deserialize(MapAccessDeserializer::new(&mut map))?;
            // An enum takes the first key and would leave a second law unread.
            match map.next_key::<IgnoredAny>()? {
                None => Ok(Some(law)),
                Some(_) => Err(A::Error::custom("wanted exactly 1 element, more than 1 element")),
            }
        }
    }

    input.deserialize_any(LawOrNone(PhantomData)).map(Some)
}

/// Writes a law, or the word "none".
#[allow(clippy::ref_option, clippy::option_option, reason = "the signature serde asks for")]
pub(super) fn serialize<L: Serialize, S: Serializer>(law: &Option<Option<L>>, output: S) -> Result<S::Ok, S::Error> {
    match law {
        Some(Some(law)) => law.serialize(output),
        _ => output.serialize_str("none"),
    }
}

/// One number, or an array of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Magnitudes(pub Vec<f64>);

impl Serialize for Magnitudes {
    fn serialize<S: Serializer>(&self, output: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(output)
    }
}

impl<'de> Deserialize<'de> for Magnitudes {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        struct OneOrSeveral;

        impl<'de> Visitor<'de> for OneOrSeveral {
            type Value = Magnitudes;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a number or an array of numbers")
            }

            fn visit_f64<E: Error>(self, number: f64) -> Result<Magnitudes, E> {
                Ok(Magnitudes(vec![number]))
            }

            fn visit_i64<E: Error>(self, number: i64) -> Result<Magnitudes, E> {
                Ok(Magnitudes(vec![number as f64]))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut numbers: A) -> Result<Magnitudes, A::Error> {
                let mut magnitudes = Vec::new();
                while let Some(number) = numbers.next_element()? {
                    magnitudes.push(number);
                }
                Ok(Magnitudes(magnitudes))
            }
        }

        input.deserialize_any(OneOrSeveral)
    }
}

/// One whole number, or an array of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Intervals(pub Vec<u64>);

impl Serialize for Intervals {
    fn serialize<S: Serializer>(&self, output: S) -> Result<S::Ok, S::Error> {
        match self.0.as_slice() {
            [only] => only.serialize(output),
            several => several.serialize(output),
        }
    }
}

impl<'de> Deserialize<'de> for Intervals {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        struct OneOrSeveral;

        impl<'de> Visitor<'de> for OneOrSeveral {
            type Value = Intervals;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a whole number of at least 1 or an array of them")
            }

            fn visit_i64<E: Error>(self, number: i64) -> Result<Intervals, E> {
                let unfit = |_| E::invalid_value(Unexpected::Signed(number), &self);
                u64::try_from(number).map(|number| Intervals(vec![number])).map_err(unfit)
            }

            fn visit_u64<E: Error>(self, number: u64) -> Result<Intervals, E> {
                Ok(Intervals(vec![number]))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut numbers: A) -> Result<Intervals, A::Error> {
                let mut intervals = Vec::new();
                while let Some(number) = numbers.next_element()? {
                    intervals.push(number);
                }
                Ok(Intervals(intervals))
            }
        }

        input.deserialize_any(OneOrSeveral)
    }
}

/// Reads three numbers, no more and no fewer.
pub(super) fn three<'de, D: Deserializer<'de>>(input: D) -> Result<Option<[f64; 3]>, D::Error> {
    let numbers = Vec::<f64>::deserialize(input)?;
    <[f64; 3]>::try_from(numbers)
        .map(Some)
        .map_err(|numbers| D::Error::invalid_length(numbers.len(), &"three numbers, one for each side"))
}
