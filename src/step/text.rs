//! Part 21 tokens: reals, strings, lists of references.

/// A real as Part 21 wants it: a point always, exponent `E`, shortest digits that read back to
/// the same bits; minus zero is `0.`. The value must be finite.
pub fn push_real(out: &mut Vec<u8>, x: f64) {
    debug_assert!(x.is_finite());
    if x == 0.0 {
        out.extend_from_slice(b"0.");
        return;
    }
    let mut buffer = zmij::Buffer::new();
    let text = buffer.format_finite(x).as_bytes();
    // an exponent has at most five bytes; a number without one has a point
    let tail = text.len().saturating_sub(5);
    let mantissa = match text[tail..].iter().position(|&c| c == b'e') {
        None => text,
        Some(at) => &text[..tail + at],
    };
    out.extend_from_slice(mantissa.strip_suffix(b"0").filter(|whole| whole.ends_with(b".")).unwrap_or(mantissa));
    if mantissa.len() < text.len() {
        if !mantissa.contains(&b'.') {
            out.push(b'.');
        }
        out.push(b'E');
        out.extend_from_slice(&text[mantissa.len() + 1..]);
    }
}

/// [`push_real`] as a string.
pub fn real(x: f64) -> String {
    let mut out = vec![];
    push_real(&mut out, x);
    String::from_utf8(out).expect("reals are ASCII")
}

/// A real rounded to so many decimals, at most 15, zeros behind the last other digit left out; all its digits where a double does not tell such places apart, or where
/// no number is given. A fraction of the work of [`push_real`].
#[inline]
pub fn push_rounded(out: &mut Vec<u8>, x: f64, decimals: Option<u32>) {
    let Some(decimals) = decimals else { return push_real(out, x) };
    let scaled = x.abs() * POWERS[decimals as usize];
    if !(scaled < MOST_WHOLE) {
        return push_real(out, x);
    }
    let number = (scaled + 0.5) as u64;
    let digits = Numeral::of(number);
    let point = DIGITS - decimals as usize;
    // All digits around the point, the sign before the first that is wanted, then that part of it.
    let mut text = [0; 40];
    text[1..=DIGITS].copy_from_slice(&digits.0.to_le_bytes());
    text[point + 1] = b'.';
    text[point + 2..point + 2 + DIGITS].copy_from_slice(&digits.0.checked_shr(8 * point as u32).unwrap_or(0).to_le_bytes());
    let mut from = digits.first().min(point - 1) + 1;
    if x < 0.0 && number > 0 {
        from -= 1;
        text[from] = b'-';
    }
    let to = digits.last().max(point) + 2;
    push_part::<24>(out, text[from..from + 24].try_into().expect("24 bytes"), to - from);
}

/// The first bytes of a block: copies of a fixed length, cut afterwards, cost less than those of an unknown one.
#[inline]
fn push_part<const N: usize>(out: &mut Vec<u8>, block: &[u8; N], length: usize) {
    let end = out.len() + length;
    out.extend_from_slice(block);
    out.truncate(end);
}

/// Below this a double has places behind the point, and at most `DIGITS` digits before it.
const MOST_WHOLE: f64 = (1u64 << 52) as f64;

/// Powers of ten: exact.
const POWERS: [f64; 16] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];

/// Decimal digits of a whole number below 10^16, leading zeros among them, as bytes of a word: the first digit in the lowest.
#[derive(Clone, Copy)]
struct Numeral(u128);

const DIGITS: usize = 16;
const ZEROS: u128 = u128::from_le_bytes([b'0'; DIGITS]);

impl Numeral {
    #[inline]
    fn of(n: u64) -> Self {
        let half = 100_000_000;
        Numeral(ZEROS + (u128::from(eight_digits(n / half)) | u128::from(eight_digits(n % half)) << 64))
    }

    /// Place of the first digit that is not 0; `DIGITS` if there is none.
    #[inline]
    fn first(self) -> usize {
        (self.0 ^ ZEROS).trailing_zeros() as usize / 8
    }

    /// Place behind the last digit that is not 0.
    #[inline]
    fn last(self) -> usize {
        DIGITS - (self.0 ^ ZEROS).leading_zeros() as usize / 8
    }
}

/// The digits of a number below 10^8, one a byte, the first in the lowest: all parts of a hundred, then of ten, in one word.
#[inline]
fn eight_digits(n: u64) -> u64 {
    let fours = n / 10_000 | (n % 10_000) << 32;
    // x / 100 for x < 10^4, x / 10 for x < 100
    let hundreds = (fours * 10_486 >> 20) & 0x7f_0000_007f;
    let twos = hundreds | (fours - 100 * hundreds) << 16;
    let tens = (twos * 103 >> 10) & 0x000f_000f_000f_000f;
    tens | (twos - 10 * tens) << 8
}

/// A quoted string: quotes and backslashes doubled, control characters and all that is not
/// ASCII as `\X2\....\X0\` (`\X4\` beyond the basic plane).
pub fn string(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 2);
    out.push('\'');
    // The escape that is open: 2 or 4 bytes a character.
    let mut open = 0;
    for c in text.chars() {
        let width = if c.is_ascii() && !c.is_control() { 0 } else { 2 + 2 * (c as u32 > 0xFFFF) as u32 };
        if width != open {
            if open != 0 {
                out.push_str("\\X0\\");
            }
            if width != 0 {
                out.push_str(if width == 2 { "\\X2\\" } else { "\\X4\\" });
            }
            open = width;
        }
        match (width, c) {
            (0, '\'') => out.push_str("''"),
            (0, '\\') => out.push_str("\\\\"),
            (0, c) => out.push(c),
            (2, c) => out.push_str(&format!("{:04X}", c as u32)),
            (_, c) => out.push_str(&format!("{:08X}", c as u32)),
        }
    }
    if open != 0 {
        out.push_str("\\X0\\");
    }
    out.push('\'');
    out
}

/// `#id`
#[inline]
pub fn push_ref(out: &mut Vec<u8>, id: u64) {
    out.push(b'#');
    push_integer(out, id);
}

/// A whole number below 10^16.
#[inline]
pub fn push_integer(out: &mut Vec<u8>, n: u64) {
    let digits = Numeral::of(n);
    let from = digits.first().min(DIGITS - 1);
    push_part(out, &(digits.0 >> (8 * from)).to_le_bytes(), DIGITS - from);
}

/// `(a,b,...)` of whatever `item` writes.
pub fn push_list<T>(out: &mut Vec<u8>, items: impl IntoIterator<Item = T>, mut item: impl FnMut(&mut Vec<u8>, T)) {
    out.push(b'(');
    for (k, x) in items.into_iter().enumerate() {
        if k > 0 {
            out.push(b',');
        }
        item(out, x);
    }
    out.push(b')');
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn reals() {
        for (x, text) in
            [(0.0, "0."), (-0.0, "0."), (1.0, "1."), (-2.5, "-2.5"), (100.0, "100."), (1e-7, "1.E-7"), (1.5e-9, "1.5E-9"), (1e22, "1.E22"), (0.1, "0.1")]
        {
            assert_eq!(real(x).replace("E+", "E"), text);
        }
    }

    fn rounded(x: f64, decimals: u32) -> String {
        let mut out = vec![];
        push_rounded(&mut out, x, Some(decimals));
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn rounding() {
        for (x, decimals, text) in [
            (1.0 / 3.0, 10, "0.3333333333"),
            (-2.0 / 3.0, 3, "-0.667"),
            (-1e-12, 10, "0."),
            (0.0, 10, "0."),
            (-0.0, 0, "0."),
            (12.5, 4, "12.5"),
            (-3.0, 15, "-3."),
            (0.000_020_5, 7, "0.0000205"),
            (99.999_999_99, 3, "100."),
            (1234.56, 0, "1235."),
            (123_456_789.123_456_79, 12, "123456789.12345679"),
        ] {
            assert_eq!(rounded(x, decimals), text);
        }
        assert_eq!(rounded(1e300, 10).replace("E+", "E"), "1.E300");
    }

    #[test]
    fn strings() {
        assert_eq!(string("it's a \\ test\n\u{7f}"), r"'it''s a \\ test\X2\000A007F\X0\'");
        assert_eq!(string("Gitter größe"), "'Gitter gr\\X2\\00F600DF\\X0\\e'");
        assert_eq!(string("é🦀x"), "'\\X2\\00E9\\X0\\\\X4\\0001F980\\X0\\x'");
        assert_eq!(string("');\n#9=EVIL();"), r"''');\X2\000A\X0\#9=EVIL();'");
    }

    #[test]
    fn integers_and_lists() {
        let mut out = vec![];
        push_list(&mut out, [0, 7, 1234567890], push_ref);
        assert_eq!(out, b"(#0,#7,#1234567890)");
    }

    proptest! {
        #[test]
        fn reals_read_back_to_the_same_bits(bits: u64) {
            let x = f64::from_bits(bits);
            prop_assume!(x.is_finite() && x != 0.0);
            let text = real(x);
            prop_assert!(text.contains('.') && !text.contains('e'));
            prop_assert_eq!(text.parse::<f64>().unwrap().to_bits(), bits);
        }

        /// As good as a round to the next decimal, and never a token that a reader could take for something else.
        #[test]
        fn rounded_reals_are_near(x in -1e6..1e6f64, decimals in 0u32..=15) {
            let text = rounded(x, decimals);
            let digits = text.strip_prefix('-').unwrap_or(&text);
            prop_assert!(digits.split_once('.').is_some_and(|(whole, part)| !whole.is_empty() && (whole.bytes().chain(part.bytes())).all(|c| c.is_ascii_digit())));
            let off = (text.parse::<f64>().unwrap() - x).abs();
            prop_assert!(off <= 0.5000001 * 10f64.powi(-(decimals as i32)) + 2.0 * f64::EPSILON * x.abs(), "{} {}", text, off);
        }

        #[test]
        fn integers(n in 0u64..10_000_000_000_000_000, shift in 0u32..54) {
            let mut out = vec![];
            push_integer(&mut out, n >> shift);
            prop_assert_eq!(String::from_utf8(out).unwrap(), (n >> shift).to_string());
        }

        #[test]
        fn strings_are_ascii_and_quotes_balance(text: String) {
            let quoted = string(&text);
            prop_assert!(quoted.bytes().all(|b| (32..127).contains(&b)));
            let inside = &quoted[1..quoted.len() - 1];
            prop_assert!(!inside.replace("''", "").contains('\''));
        }
    }
}
