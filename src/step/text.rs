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

/// `x` rounded to `decimals` places, where a double still tells such places apart.
pub fn round(x: f64, decimals: Option<u32>) -> f64 {
    let Some(decimals) = decimals else { return x };
    let scale = 10f64.powi(decimals as i32);
    let scaled = x * scale;
    // Past 2^52 every double is whole already.
    if scaled.abs() < 4.5e15 { scaled.round() / scale } else { x }
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
pub fn push_ref(out: &mut Vec<u8>, id: u64) {
    out.push(b'#');
    push_integer(out, id);
}

/// A whole number.
pub fn push_integer(out: &mut Vec<u8>, n: u64) {
    out.extend_from_slice(itoa::Buffer::new().format(n).as_bytes());
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

    #[test]
    fn rounding() {
        assert_eq!(real(round(1.0 / 3.0, Some(10))), "0.3333333333");
        assert_eq!(round(1e300, Some(10)), 1e300);
        assert_eq!(real(round(-1e-12, Some(10))), "0.");
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

        #[test]
        fn strings_are_ascii_and_quotes_balance(text: String) {
            let quoted = string(&text);
            prop_assert!(quoted.bytes().all(|b| (32..127).contains(&b)));
            let inside = &quoted[1..quoted.len() - 1];
            prop_assert!(!inside.replace("''", "").contains('\''));
        }
    }
}
