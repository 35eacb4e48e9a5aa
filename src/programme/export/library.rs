//! The functions that exported programmes are made of, written once, in the part of WGSL that [`super::glsl`] can translate.

/// Items are apart by empty lines and come in an order in which what is used stands first.
const LIBRARY: &str = include_str!("library.wgsl");

/// What an item defines: the word after `fn`, `const` or `struct`.
fn name(item: &str) -> Option<&str> {
    let line = item.lines().find(|line| !line.starts_with("//"))?;
    let (_, rest) = line.split_once(' ')?;
    rest.split(|c: char| !is_word(c)).next()
}

fn is_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

fn mentions(text: &str, name: &str) -> bool {
    text.split(|c: char| !is_word(c)).any(|word| word == name)
}

/// The items that a text uses, in the library's order.
pub(super) fn used_by(text: &str) -> String {
    let items: Vec<(&str, &str)> = LIBRARY.split("\n\n").map(str::trim).filter_map(|item| name(item).map(|name| (name, item))).collect();
    let mut used = vec![false; items.len()];
    // What an item uses stands before it.
    for i in (0..items.len()).rev() {
        let by_later = items.iter().zip(&used).skip(i + 1).any(|((_, item), used)| *used && mentions(item, items[i].0));
        used[i] = by_later || mentions(text, items[i].0);
    }
    let mut all = String::new();
    for ((_, item), _) in items.iter().zip(used).filter(|(_, used)| *used) {
        all.push_str(item);
        all.push_str("\n\n");
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_used_comes_with_what_it_uses() {
        let text = used_by("terrane_power(a, b)");
        let names: Vec<_> = text.split("\n\n").filter_map(name).collect();
        assert_eq!(names, ["terrane_ln", "terrane_exp", "terrane_power"]);
        assert_eq!(used_by("a + b"), "");
    }
}
