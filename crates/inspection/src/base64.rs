//! Bytes as text (RFC 4648, section 4).

const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Bytes in base64.
pub(crate) fn encode(bytes: &[u8]) -> String {
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for triple in bytes.chunks(3) {
        let bits =
            triple.iter().fold(0u32, |bits, &byte| (bits << 8) | u32::from(byte)) << (8 * (3 - triple.len()));
        for place in 0..4 {
            let digit = (bits >> (18 - 6 * place)) & 63;
            out.push(if place <= triple.len() { char::from(ALPHABET[digit as usize]) } else { '=' });
        }
    }
    out
}

/// The bytes of a text in base64; `None` for any other text.
pub(crate) fn decode(text: &str) -> Option<Vec<u8>> {
    let digit = |letter: u8| -> Option<u32> {
        let (first, base) = match letter {
            b'A'..=b'Z' => (b'A', 0),
            b'a'..=b'z' => (b'a', 26),
            b'0'..=b'9' => (b'0', 52),
            b'+' => return Some(62),
            b'/' => return Some(63),
            _ => return None,
        };
        Some(u32::from(letter - first) + base)
    };
    let whole = text.trim_end_matches('=');
    if !text.len().is_multiple_of(4) || text.len() - whole.len() > 2 {
        return None;
    }
    let mut out = Vec::with_capacity(text.len() / 4 * 3);
    for letters in whole.as_bytes().chunks(4) {
        let bits = letters.iter().try_fold(0u32, |bits, &letter| Some((bits << 6) | digit(letter)?))?;
        let bits = bits << (6 * (4 - letters.len()));
        out.extend_from_slice(&bits.to_be_bytes()[1..letters.len()]);
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_every_length_and_back() {
        let texts = ["", "f", "fo", "foo", "foob", "fooba", "foobar"];
        let encoded = texts.map(|text| encode(text.as_bytes()));
        assert_eq!(encoded, ["", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"]);
        for (text, encoded) in texts.iter().zip(encoded) {
            assert_eq!(decode(&encoded).unwrap(), text.as_bytes());
        }
        for wrong in ["Z", "Zg=", "Zg", "Z===", "Zm9v!A==", "Zm=v"] {
            assert_eq!(decode(wrong), None, "{wrong}");
        }
    }
}
