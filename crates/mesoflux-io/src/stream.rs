//! Values to and from streams of bytes in postcard's encoding, one after the other, without a copy of them all in memory.

use postcard::de_flavors::Flavor;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::io::{self, Read, Write};

/// Writes the encoding of a value.
///
/// # Errors
/// Those of `out`.
pub fn write<T: Serialize + ?Sized>(out: &mut (impl Write + ?Sized), value: &T) -> io::Result<()> {
    let mut kept = KeepsFailure { out, failure: None };
    let written = postcard::to_io(value, &mut kept).map(drop);
    written.map_err(|error| kept.failure.take().unwrap_or_else(|| io::Error::other(error)))
}

/// A writer that remembers its failure, of which postcard tells nothing.
struct KeepsFailure<'a, W: ?Sized> {
    out: &'a mut W,
    failure: Option<io::Error>,
}

impl<W: Write + ?Sized> Write for KeepsFailure<'_, W> {
    #[inline]
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.write_all(bytes).map(|()| bytes.len())
    }

    #[inline]
    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.out.write_all(bytes).map_err(|error| {
            let kind = error.kind();
            self.failure = Some(error);
            kind.into()
        })
    }

    /// More values may follow: nothing is flushed yet.
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A writer that counts the bytes and keeps none.
#[derive(Debug, Default)]
pub struct Count(pub u64);

impl Write for Count {
    #[inline]
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Reads values from a stream of known length.
#[derive(Debug)]
pub struct Values<R> {
    reader: R,
    left: u64,
    failure: Option<io::Error>,
    scratch: Vec<u8>,
}

impl<R: Read> Values<R> {
    /// The values in the next `length` bytes; many small pieces are read, so `reader` should be buffered.
    pub fn new(reader: R, length: u64) -> Self {
        Self { reader, left: length, failure: None, scratch: Vec::new() }
    }

    /// The next value. A length in the stream allocates nothing beyond what the stream can fill, and a little.
    ///
    /// # Errors
    /// Bytes that are no such value, or that can't be read.
    pub fn next_value<T: DeserializeOwned>(&mut self) -> Result<T, String> {
        let mut deserializer = postcard::Deserializer::from_flavor(Pieces(self));
        let value = T::deserialize(&mut deserializer);
        value.map_err(|error| self.failure.take().map_or_else(|| error.to_string(), |failure| failure.to_string()))
    }

    /// How many bytes are left.
    pub fn left(&self) -> u64 {
        self.left
    }

    #[inline]
    fn fill(&mut self, piece: &mut [u8]) -> postcard::Result<()> {
        let left = self.left.checked_sub(piece.len() as u64).ok_or(postcard::Error::DeserializeUnexpectedEnd)?;
        self.reader.read_exact(piece).map_err(|failure| {
            self.failure = Some(failure);
            postcard::Error::DeserializeUnexpectedEnd
        })?;
        self.left = left;
        Ok(())
    }
}

/// The stream as postcard takes it, piece by piece.
struct Pieces<'a, R>(&'a mut Values<R>);

impl<'de, R: Read + 'de> Flavor<'de> for Pieces<'de, R> {
    type Remainder = ();
    type Source = ();

    #[inline]
    fn pop(&mut self) -> postcard::Result<u8> {
        let mut byte = [0];
        self.0.fill(&mut byte)?;
        Ok(byte[0])
    }

    fn size_hint(&self) -> Option<usize> {
        usize::try_from(self.0.left).ok()
    }

    /// Nothing can be borrowed from a stream.
    fn try_take_n(&mut self, _count: usize) -> postcard::Result<&'de [u8]> {
        Err(postcard::Error::WontImplement)
    }

    #[inline]
    fn try_take_n_temp<'a>(&'a mut self, count: usize) -> postcard::Result<&'a [u8]>
    where
        'de: 'a,
    {
        if count as u64 > self.0.left {
            return Err(postcard::Error::DeserializeUnexpectedEnd);
        }
        let mut scratch = std::mem::take(&mut self.0.scratch);
        scratch.resize(count, 0);
        let filled = self.0.fill(&mut scratch);
        self.0.scratch = scratch;
        filled.map(|()| self.0.scratch.as_slice())
    }

    fn finalize(self) -> postcard::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Value = (u64, String, Vec<[f64; 3]>, Option<Vec<u8>>);

    fn value() -> Value {
        (300, "long enough, twice: ".repeat(900), vec![[0.5, -1.0, 1e300]; 700], Some(vec![1, 2, 255]))
    }

    #[test]
    fn what_is_written_to_a_stream_is_postcard_s_encoding_and_read_again() {
        let mut bytes = Vec::new();
        write(&mut bytes, &value()).unwrap();
        write(&mut bytes, &7u8).unwrap();
        assert_eq!(bytes, postcard::to_stdvec(&(value(), 7u8)).unwrap());
        let mut values = Values::new(bytes.as_slice(), bytes.len() as u64);
        assert_eq!((values.next_value(), values.next_value()), (Ok(value()), Ok(7u8)));
        assert_eq!((values.left(), values.next_value::<u8>().is_err()), (0, true));
    }

    #[test]
    fn no_truncated_stream_and_no_length_beyond_its_end_is_accepted() {
        let mut bytes = Vec::new();
        write(&mut bytes, &value()).unwrap();
        for length in (0..bytes.len()).step_by(97) {
            assert!(
                Values::new(bytes.as_slice(), length as u64).next_value::<Value>().is_err(),
                "cut to {length} bytes"
            );
            assert!(
                Values::new(&bytes[..length], bytes.len() as u64).next_value::<Value>().is_err(),
                "{length} bytes there"
            );
        }
        let huge = postcard::to_stdvec(&u64::MAX).unwrap();
        assert!(Values::new(huge.as_slice(), huge.len() as u64).next_value::<String>().is_err());
        assert!(Values::new(huge.as_slice(), huge.len() as u64).next_value::<Vec<[f64; 3]>>().is_err());
    }

    #[test]
    fn a_writer_s_own_failure_is_told() {
        let mut small = [0; 10];
        let failure = write(&mut small.as_mut_slice(), &value()).unwrap_err();
        assert_eq!(failure.kind(), io::ErrorKind::WriteZero);
    }
}
