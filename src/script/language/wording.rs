//! Names in sentences: lists, articles, and suggestions for misspelt names.

/// Returns the names in `candidates` similar to `name`, nearest first.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let lower = name.to_lowercase();
    let mut scored: Vec<(f64, &str)> = candidates
        .into_iter()
        .filter(|candidate| *candidate != name)
        .map(|candidate| {
            let other = candidate.to_lowercase();
            let similarity = strsim::jaro_winkler(&lower, &other);
            let distance = strsim::damerau_levenshtein(&lower, &other);
            let close = distance <= 1 + lower.chars().count().min(other.chars().count()) / 4;
            let (short, long) = (lower.len().min(other.len()), lower.len().max(other.len()));
            let inside = short >= 3 && 2 * short >= long && (other.contains(&lower) || lower.contains(&other));
            // `half_plane` for `rigid_plane`
            let shares_a_word = lower.split('_').any(|word| word.len() >= 4 && other.split('_').any(|own| own == word));
            let score = match (close, inside || shares_a_word) {
                (true, _) => 1.0 + similarity,
                (false, true) => 0.9 + 0.05 * similarity,
                (false, false) => similarity,
            };
            (score, candidate)
        })
        .filter(|(score, _)| *score >= 0.88)
        .collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(b.1)));
    scored.dedup_by(|a, b| a.1 == b.1);
    let best = scored.first().map_or(0.0, |(score, _)| *score);
    scored.into_iter().filter(|(score, _)| *score > best - 0.3).take(3).map(|(_, candidate)| candidate).collect()
}

/// Returns ``did you mean `a` or `b`?``, or `None` if no name is similar.
pub fn did_you_mean<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let near = nearest(name, candidates);
    (!near.is_empty()).then(|| format!("did you mean {}?", listed(&near, "or")))
}

/// Names in code quotes, the last one after the word `joint`, such as `` `a`, `b` and `c` ``.
pub fn listed<S: AsRef<str>>(names: &[S], joint: &str) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{}`", name.as_ref())).collect();
    joined(&quoted, joint)
}

/// Joins words as in `a, b and c`.
pub fn joined<S: AsRef<str>>(words: &[S], joint: &str) -> String {
    match words {
        [] => String::new(),
        [only] => only.as_ref().to_string(),
        [first @ .., last] => {
            format!("{} {joint} {}", first.iter().map(AsRef::as_ref).collect::<Vec<_>>().join(", "), last.as_ref())
        }
    }
}

/// Name with its article: `a Mesh`, `an Integrator`.
pub fn with_article(name: &str) -> String {
    let vowel = name.chars().next().is_some_and(|first| "AEIOUaeiou".contains(first));
    format!("{} {name}", if vowel { "an" } else { "a" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_names_are_found_and_far_ones_are_not() {
        let names = ["inner_radius", "outer_radius", "cells", "center", "start_angle"];
        assert_eq!(nearest("outter_radius", names)[0], "outer_radius");
        assert_eq!(nearest("radius", names), ["inner_radius", "outer_radius"]);
        assert_eq!(nearest("Cells", names)[0], "cells");
        assert!(nearest("velocity", names).is_empty());
        assert_eq!(did_you_mean("cell", names).unwrap(), "did you mean `cells`?");
    }

    #[test]
    fn lists_read_like_sentences() {
        assert_eq!(listed(&["a"], "and"), "`a`");
        assert_eq!(listed(&["a", "b", "c"], "and"), "`a`, `b` and `c`");
    }
}
