//! Settings files.

use std::path::Path;

use occluscope::settings::{Preset, SETTINGS, Settings};

use super::check_message;

pub fn run(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let path = Path::new("my.toml");
    for preset in [Preset::Plain, Preset::Default] {
        let mut settings = Settings::preset(preset);
        let outcome = settings.apply_toml(text, path);
        // A refused file can have set some.
        for setting in SETTINGS {
            let value = setting.get(&settings);
            assert!(setting.kind.contains(value), "{} is {value}", setting.name);
        }
        if let Err(error) = outcome {
            let message = error.to_string();
            check_message(&message);
            assert!(message.contains("my.toml"), "{message}");
        }
        let mut again = Settings::preset(Preset::Paper);
        again.apply_toml(&settings.to_toml(), path).unwrap();
        assert_eq!(again.first_difference(&settings), None);
        serde_json::to_string(&settings).unwrap();
    }
}
