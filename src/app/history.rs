//! Undo and redo of settings.

use crate::settings::Settings;

/// How many changes can be taken back.
const DEPTH: usize = 200;

/// Settings as they were, and as they were before something was taken back.
#[derive(Clone, Debug)]
pub(crate) struct History {
    present: Settings,
    past: Vec<Settings>,
    future: Vec<Settings>,
}

impl History {
    /// A history that starts here.
    pub(crate) const fn new(present: Settings) -> Self {
        Self { present, past: Vec::new(), future: Vec::new() }
    }

    /// Notes settings that have come to rest; nothing when they are those that were last noted.
    pub(crate) fn note(&mut self, settings: &Settings) {
        if *settings == self.present {
            return;
        }
        self.past.push(std::mem::replace(&mut self.present, settings.clone()));
        if self.past.len() > DEPTH {
            self.past.remove(0);
        }
        self.future.clear();
    }

    /// The settings before the last change.
    pub(crate) fn undo(&mut self) -> Option<Settings> {
        let before = self.past.pop()?;
        self.future.push(std::mem::replace(&mut self.present, before.clone()));
        Some(before)
    }

    /// The settings after the change that was last taken back.
    pub(crate) fn redo(&mut self) -> Option<Settings> {
        let after = self.future.pop()?;
        self.past.push(std::mem::replace(&mut self.present, after.clone()));
        Some(after)
    }

    /// Whether there is something to take back, and to make again.
    pub(crate) fn can(&self) -> (bool, bool) {
        (!self.past.is_empty(), !self.future.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_taken_back_and_made_again_until_another_is_made() {
        let start = Settings::default();
        let (two, five) = (Settings { k: 2, ..start.clone() }, Settings { k: 5, ..start.clone() });
        let mut history = History::new(start.clone());
        history.note(&start);
        assert_eq!(history.can(), (false, false));
        history.note(&two);
        history.note(&five);
        assert_eq!(history.undo(), Some(two.clone()));
        assert_eq!(history.undo(), Some(start.clone()));
        assert_eq!(history.undo(), None);
        assert_eq!(history.redo(), Some(two));
        history.note(&start);
        assert_eq!(history.redo(), None);
    }
}
