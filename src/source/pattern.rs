//! printf patterns for numbered files: `in%06d.png`.

/// The text before and after the number, and the number's format.
#[derive(Debug, PartialEq)]
pub(super) struct Pattern {
    before: String,
    after: String,
    width: usize,
    zeros: bool,
}

impl Pattern {
    /// Parses a file name with one of `%d`, `%5d`, `%05d`; `%%` is a percent sign.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let mut texts = [String::new(), String::new()];
        let mut number = None;
        let mut rest = text.chars().peekable();
        while let Some(c) = rest.next() {
            if c != '%' {
                texts[usize::from(number.is_some())].push(c);
                continue;
            }
            if rest.next_if_eq(&'%').is_some() {
                texts[usize::from(number.is_some())].push('%');
                continue;
            }
            let zeros = rest.next_if_eq(&'0').is_some();
            let mut width = 0;
            while let Some(digit) = rest.peek().and_then(|c| c.to_digit(10)) {
                width = width * 10 + digit as usize;
                rest.next();
                if width > 64 {
                    return None;
                }
            }
            if !matches!(rest.next(), Some('d' | 'i' | 'u')) || number.replace((width, zeros)).is_some() {
                return None;
            }
        }
        let (width, zeros) = number?;
        let [before, after] = texts;
        Some(Self { before, after, width, zeros })
    }

    /// The number in `name`; `None` if the pattern cannot print `name`.
    pub(super) fn number_in(&self, name: &str) -> Option<u32> {
        let written = name.strip_prefix(&self.before)?.strip_suffix(&self.after)?;
        let number: u32 = written.trim_start_matches(' ').parse().ok()?;
        let Self { width, zeros, .. } = *self;
        let printed = if zeros { format!("{number:0width$}") } else { format!("{number:width$}") };
        (printed == written).then_some(number)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

    use super::*;

    #[test]
    fn a_pattern_accepts_the_names_that_it_prints() {
        let padded = Pattern::parse("in%06d.png").unwrap();
        assert_eq!(padded.number_in("in000470.png"), Some(470));
        assert_eq!(padded.number_in("in1234567.png"), Some(1_234_567));
        assert_eq!(padded.number_in("in470.png"), None);
        assert_eq!(padded.number_in("in000470.jpg"), None);
        assert_eq!(padded.number_in("in+00470.png"), None);
        let plain = Pattern::parse("%d.jpg").unwrap();
        assert_eq!(plain.number_in("0.jpg"), Some(0));
        assert_eq!(plain.number_in("07.jpg"), None);
        assert_eq!(Pattern::parse("50%%_%3d").unwrap().number_in("50%_  7"), Some(7));
        assert_eq!(Pattern::parse("a%da").unwrap().number_in("a"), None, "before and after do not overlap");
    }

    #[test]
    fn an_invalid_pattern_is_refused() {
        for text in ["in.png", "in%s.png", "%d_%d.png", "100%", "%-5d.png", "%999999999999999999999d"] {
            assert_eq!(Pattern::parse(text), None, "{text}");
        }
    }
}
