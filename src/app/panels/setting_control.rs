//! The control of a setting: name and symbol, editable value, slider, and reset to the default.

use eframe::egui::{
    Align, Button, ComboBox, DragValue, Layout, Response, RichText, Slider, SliderClamping, Ui, vec2,
};
use egui_material_icons::icons as m;

use crate::app::panels::setting_help;
use crate::app::theme;
use crate::settings::{Kind, Setting, Settings, Span, Value};

/// A range of integers whose ends have at least this ratio gets a logarithmic slider.
const MIN_LOGARITHMIC_RATIO: u32 = 200;

/// Draws the control and writes a change to `settings`. Returns its response.
pub(crate) fn ui(
    ui: &mut Ui,
    setting: &'static Setting,
    settings: &mut Settings,
    defaults: &Settings,
    fps: f32,
) -> Response {
    let colours = theme::colours(ui.visuals());
    let before = setting.get(settings);
    let differs = before != setting.get(defaults);
    let mut value = before;
    let whole = ui.push_id(setting.name, |ui| {
        ui.add_space(theme::SPACE / 2.0);
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = theme::SPACE;
            let name = setting.label();
            let name = RichText::new(name).color(if differs { colours.accent } else { colours.text });
            let label = ui.label(name).on_hover_ui(|ui| tooltip(ui, setting, defaults));
            if !setting.symbol.is_empty() {
                let symbol = RichText::new(setting.symbol).size(theme::MONO_TEXT).color(colours.weak);
                ui.label(symbol).on_hover_ui(|ui| tooltip(ui, setting, defaults));
            }
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                ui.spacing_mut().item_spacing.x = theme::SPACE;
                ui.name_inputs(setting.label(), |ui| exact(ui, setting, &mut value, fps, label.id));
                reset(ui, setting, differs, &mut value, defaults);
            });
        });
        slider(ui, setting, &mut value);
    });
    if value != before {
        // The controls stay within the ranges. A value that is still rejected leaves the setting unchanged.
        let _ = setting.set(settings, value);
    }
    whole.response
}

fn tooltip(ui: &mut Ui, setting: &Setting, defaults: &Settings) {
    let symbol = if setting.symbol.is_empty() { String::new() } else { format!("  {}", setting.symbol) };
    ui.strong(format!("{}{symbol}", setting.name));
    ui.label(setting.meaning.trim());
    if let Some(help) = setting_help::help(setting.name) {
        ui.add_space(theme::SPACE);
        ui.monospace(help.equation);
        ui.add_space(theme::SPACE);
        if !matches!(setting.kind, Kind::Choice(_)) {
            ui.weak("Increasing it:");
        }
        ui.label(help.raising);
        ui.add_space(theme::SPACE);
    }
    let unit = if setting.unit.is_empty() { String::new() } else { format!(" {}", setting.unit) };
    ui.weak(format!("Range: {}{unit}", setting.kind.range(setting.symbol)));
    ui.weak(format!("Default: {}{unit}", setting.get(defaults)));
    ui.weak(format!("Command-line flag: --{}", setting.flag()));
}

fn reset(ui: &mut Ui, setting: &Setting, differs: bool, value: &mut Value, defaults: &Settings) {
    let default = setting.get(defaults);
    let icon = m::ICON_RESTART_ALT.rich_text().size(14.0);
    let button = Button::new(icon).frame_when_inactive(false).min_size(vec2(20.0, 18.0));
    ui.spacing_mut().button_padding = vec2(2.0, 0.0);
    let response = ui.add_visible(differs, button).accessible_name(format!("Reset {}", setting.label()));
    if response.on_hover_text(format!("Reset to the default, {default}")).clicked() {
        *value = default;
    }
}

/// The value, edited by typing or dragging.
fn exact(ui: &mut Ui, setting: &Setting, value: &mut Value, fps: f32, label: eframe::egui::Id) {
    match (setting.kind, *value) {
        (Kind::Integer { min, max }, Value::Integer(mut number)) => {
            let drag = DragValue::new(&mut number).range(min..=max).suffix(suffix(setting));
            if ui.add(drag).labelled_by(label).changed() {
                *value = Value::Integer(number);
            }
        }
        (Kind::OddSize { max }, Value::Integer(number)) => {
            let mut typed = f64::from(number);
            let drag = DragValue::new(&mut typed)
                .range(0.0..=f64::from(max))
                .speed(0.1)
                .custom_formatter(
                    |number, _| if number < 1.0 { "off".to_owned() } else { format!("{number}") },
                )
                .custom_parser(
                    |text| if text.trim() == "off" { Some(0.0) } else { text.trim().parse().ok() },
                );
            if ui.add(drag).labelled_by(label).changed() {
                *value = Value::Integer(odd(typed, max));
            }
        }
        (Kind::Real { min, max, open, logarithmic }, Value::Real(number)) => {
            let mut typed = exact_f64(number);
            let (min, max) = ends(min, max, open);
            let speed = if logarithmic { (typed * 0.01).max(1e-4) } else { f64::from(max - min) / 400.0 };
            let drag = DragValue::new(&mut typed)
                .range(exact_f64(min)..=exact_f64(max))
                .speed(speed)
                .max_decimals(5)
                .custom_formatter(|number, _| short(number))
                .suffix(suffix(setting));
            if ui.add(drag).labelled_by(label).changed() {
                *value = Value::Real((typed as f32).clamp(min, max));
            }
        }
        (Kind::Choice(words), Value::Choice(word)) => {
            let combo = ComboBox::from_id_salt("choice").selected_text(word).width(96.0);
            let response = combo.show_ui(ui, |ui| {
                for &each in words {
                    if ui.selectable_label(each == word, each).clicked() {
                        *value = Value::Choice(each);
                    }
                }
            });
            response.response.labelled_by(label);
        }
        (Kind::Span { max_frames, max_seconds }, Value::Span(span)) => {
            *value =
                Value::Span(span_control(ui, span, (max_frames, max_seconds), fps, &setting.label(), label));
        }
        // A setting always holds a value of its own kind.
        _ => {}
    }
}

fn span_control(
    ui: &mut Ui,
    span: Span,
    (max_frames, max_seconds): (u32, f32),
    fps: f32,
    name: &str,
    label: eframe::egui::Id,
) -> Span {
    let mut changed = span;
    let (unit, other) = match span {
        Span::Frames(_) => ("frames", format!("= {} s", short(f64::from(span.seconds(fps))))),
        Span::Seconds(_) => ("s", format!("= {} frames", span.frames(fps))),
    };
    let response = ui.add(Button::new(unit).min_size(vec2(46.0, 0.0)));
    if response.accessible_name(format!("{name} unit")).on_hover_text("Frames or seconds").clicked() {
        changed = match span {
            Span::Frames(_) => Span::Seconds(span.seconds(fps).min(max_seconds)),
            Span::Seconds(_) => Span::Frames(span.frames(fps).min(max_frames)),
        };
    }
    let response = match span {
        Span::Frames(mut frames) => {
            let response = ui.add(DragValue::new(&mut frames).range(0..=max_frames));
            if response.changed() {
                changed = Span::Frames(frames);
            }
            response
        }
        Span::Seconds(seconds) => {
            let mut typed = exact_f64(seconds);
            let drag =
                DragValue::new(&mut typed).range(0.0..=exact_f64(max_seconds)).speed(0.05).max_decimals(3);
            let response = ui.add(drag);
            if response.changed() {
                changed = Span::Seconds((typed as f32).clamp(0.0, max_seconds));
            }
            response
        }
    };
    response.labelled_by(label).on_hover_text(other);
    changed
}

/// A slider over the whole width, for settings that have one.
fn slider(ui: &mut Ui, setting: &Setting, value: &mut Value) {
    let name = format!("{} slider", setting.label());
    let style = |ui: &mut Ui| {
        ui.spacing_mut().slider_width = (ui.available_width() - 3.0 * theme::SPACE).max(0.0);
        ui.spacing_mut().interact_size.y = 14.0;
    };
    let plain = |slider: Slider<'_>, ui: &mut Ui| -> Response {
        ui.scope(|ui| {
            style(ui);
            ui.add(slider.show_value(false).clamping(SliderClamping::Always))
        })
        .inner
        .accessible_name(name.clone())
    };
    match (setting.kind, *value) {
        (Kind::Integer { min, max }, Value::Integer(mut number)) => {
            let wide = max / min.max(1) > MIN_LOGARITHMIC_RATIO;
            let slider = Slider::new(&mut number, min..=max).logarithmic(wide).smallest_positive(1.0);
            if plain(slider, ui).changed() {
                *value = Value::Integer(number);
            }
        }
        (Kind::OddSize { max }, Value::Integer(number)) => {
            let mut step = number / 2;
            if plain(Slider::new(&mut step, 0..=max.saturating_sub(1) / 2), ui).changed() {
                *value = Value::Integer(if step == 0 { 0 } else { 2 * step + 1 });
            }
        }
        (Kind::Real { min, max, open, logarithmic }, Value::Real(number)) => {
            let mut typed = exact_f64(number);
            let (min, max) = ends(min, max, open);
            let slider = Slider::new(&mut typed, exact_f64(min)..=exact_f64(max))
                .logarithmic(logarithmic)
                .smallest_positive(exact_f64(min).max(1e-4));
            if plain(slider, ui).changed() {
                *value = Value::Real((typed as f32).clamp(min, max));
            }
        }
        _ => {}
    }
}

fn suffix(setting: &Setting) -> String {
    match setting.unit {
        "σ" => " σ".to_owned(),
        unit if unit.starts_with('%') => " %".to_owned(),
        "pixels" => " px".to_owned(),
        _ => String::new(),
    }
}

/// The ends that a control can reach. The ends of an open range are excluded.
fn ends(min: f32, max: f32, open: bool) -> (f32, f32) {
    if open {
        let inset = (max - min) * 1e-4;
        (min + inset, max - inset)
    } else {
        (min, max)
    }
}

/// The f64 with the same decimal digits as this f32: 0.01, not 0.009999999776.
fn exact_f64(number: f32) -> f64 {
    number.to_string().parse().unwrap_or(f64::from(number))
}

/// A number with at most five significant digits, without trailing zeros.
fn short(number: f64) -> String {
    let digits = if number == 0.0 { 0 } else { (4 - number.abs().log10().floor() as i32).clamp(0, 6) };
    let text = format!("{number:.*}", digits as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// The nearest odd size, or 0 for off.
fn odd(typed: f64, max: u32) -> u32 {
    let number = typed.round().max(0.0) as u32;
    if number < 2 { 0 } else { (number | 1).clamp(3, max) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_snap_to_odd_numbers_or_off() {
        assert_eq!(
            [0.0, 1.0, 2.0, 3.0, 4.4, 30.0, 99.0].map(|typed| odd(typed, 31)),
            [0, 0, 3, 3, 5, 31, 31]
        );
    }

    #[test]
    fn numbers_are_written_without_trailing_zeros() {
        assert_eq!(short(exact_f64(0.01)), "0.01");
        assert_eq!(short(exact_f64(0.002)), "0.002");
        assert_eq!(short(51.96), "51.96");
        assert_eq!(short(0.0), "0");
        assert_eq!(short(20.0), "20");
    }
}
