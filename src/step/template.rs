//! Fills `{name}` placeholders of the texts in `step_templates/`.

/// The template with every placeholder replaced. A placeholder without a value, or a value
/// without a placeholder, is a mistake in this program and panics; the tests fill all templates.
pub fn fill(template: &str, values: &[(&str, &str)]) -> String {
    let mut out = String::with_capacity(template.len() + 256);
    let mut used = vec![false; values.len()];
    let mut rest = template;
    while let Some((before, after)) = rest.split_once('{') {
        let (name, after) = after.split_once('}').expect("every { has its }");
        let value = values.iter().position(|v| v.0 == name);
        let value = value.unwrap_or_else(|| panic!("placeholder {{{name}}} has no value"));
        used[value] = true;
        out.push_str(before);
        out.push_str(values[value].1);
        rest = after;
    }
    out.push_str(rest);
    if let Some(spare) = used.iter().position(|u| !u) {
        panic!("value {:?} has no placeholder", values[spare].0);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::fill;

    #[test]
    fn placeholders_are_replaced_once_and_values_stay_as_they_are() {
        assert_eq!(fill("a={a}, b={b}, a={a};", &[("a", "{b}"), ("b", "2")]), "a={b}, b=2, a={b};");
    }

    #[test]
    #[should_panic(expected = "{b} has no value")]
    fn missing_value() {
        fill("{b}", &[]);
    }

    #[test]
    #[should_panic(expected = "has no placeholder")]
    fn spare_value() {
        fill("", &[("a", "")]);
    }
}
