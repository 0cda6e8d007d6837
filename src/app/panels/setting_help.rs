//! Help on the settings: the equation or rule of each, and the effect of a larger value.

/// The help on one setting.
pub(crate) struct SettingHelp {
    /// Its key in the table of settings.
    name: &'static str,
    /// Its equation or rule.
    pub(crate) equation: &'static str,
    /// The effect of a larger value, or of each option.
    pub(crate) raising: &'static str,
}

/// The help on the setting of this key, if any.
pub(crate) fn help(name: &str) -> Option<&'static SettingHelp> {
    HELP.iter().find(|help| help.name == name)
}

const fn of(name: &'static str, equation: &'static str, raising: &'static str) -> SettingHelp {
    SettingHelp { name, equation, raising }
}

/// All help texts, in the order of the table of settings.
static HELP: &[SettingHelp] = &[
    of(
        "stabilise",
        "X(p) = I(A·p + d), A and d from points of high contrast",
        "off: frames are not corrected. shift, similarity: camera shake is compensated, so edges do not \
         become foreground; pixels from outside the frame are background and are not learnt. auto: \
         similarity, once shake is detected. The computation takes time only while the camera shakes.",
    ),
    of(
        "light",
        "X = (I − o) / g, g and o of each channel",
        "off: the mixture adapts to all changes of light. gain: global changes (clouds, camera exposure) \
         do not become foreground. Slow changes and changes below 4 % are left to the mixture.",
    ),
    of(
        "background_model",
        "mog2, knn: history = 1/α frames; mog2: K and T as set here",
        "mixture: the mixture of this method, which can be inspected at every pixel. mog2, knn: OpenCV's \
         models in its place; later stages are the same, but there is no mixture to inspect.",
    ),
    of(
        "k",
        "P(X) = Σ w_k · η(X; μ_k, σ_k²), k = 1..K",
        "Models more surfaces per pixel: moving leaves, glints, flashing lamps. Costs time, and rare \
         foreground may be remembered longer.",
    ),
    of(
        "alpha",
        "w_k ← (1 − α) · w_k + α · M_k",
        "The model learns faster: it follows changes of light sooner, and stationary objects become \
         background sooner. It forgets in about 1/α frames.",
    ),
    of(
        "t",
        "B = smallest b with w_1 + … + w_b > T",
        "More components count as background: repetitive motion is absorbed, and so are stationary \
         objects. A small T keeps only the strongest component.",
    ),
    of(
        "match_sigmas",
        "matched: ‖X − μ‖² ≤ λ² · σ²",
        "Values farther from a component's mean match: less noise, but foreground similar to the \
         background is missed.",
    ),
    of(
        "initial_sigma",
        "nothing matched: the last component ← (w₀, X, σ₀²)",
        "New components are wider: they cover noisy surfaces sooner, and also similar colours.",
    ),
    of(
        "initial_weight",
        "nothing matched: the last component ← (w₀, X, σ₀²), then w_k ← w_k / Σ w",
        "A new surface becomes background after fewer frames.",
    ),
    of(
        "min_sigma",
        "σ² ← max(σ², σ_min²)",
        "Suppresses noise, compression artefacts and soft shadows; foreground similar to the background \
         colour is missed.",
    ),
    of(
        "rate",
        "μ ← (1 − ρ)μ + ρX;  σ² ← (1 − ρ)σ² + ρ‖X − μ‖²",
        "density: ρ = α · η(X; μ, σ²), as in the paper; almost no adaptation in 8-bit colour. weight: ρ = \
         α / w, fast for young components. constant: ρ = α.",
    ),
    of(
        "space",
        "‖X − μ‖² = Σ (X_c − μ_c)², over the n channels",
        "rgb: n = 3, red, green and blue. gray: n = 1, luma only: faster, but colours of equal luma are \
         not distinguished.",
    ),
    of(
        "warm_up",
        "t ≤ warm_up: α ← max(α, 1/t)",
        "The first frames are averaged over a longer time, so that a person in the first frame does not \
         remain in the background.",
    ),
    of(
        "bootstrap",
        "frames 1..N first, α ← max(α, 1/t); then w₁ ← 1, component 1 alone, and frame 1 again at t = N + 1",
        "More of the background is known at frame 1: a person in it is foreground and leaves no ghost, \
         unless stationary for most of this time. Changes of mixture settings take longer to compute. Not \
         used with cameras.",
    ),
    of(
        "hold",
        "foreground for more than hold_after frames: α ← hold · α",
        "Persistent foreground is learnt faster: parked cars, ghosts and stationary people become \
         background sooner. 1 is off.",
    ),
    of(
        "hold_after",
        "foreground for more than hold_after frames: α ← hold · α",
        "Foreground must persist longer before it is learnt slowly: more repetitive motion is absorbed, \
         and more of passing objects is learnt.",
    ),
    of(
        "restless_learning",
        "foreground for 1 to hold_after frames: α ← (1 + (restless_learning − 1) · q) · α",
        "Short foreground of flickering pixels becomes background sooner: leaves, water, lamps. 1 is off.",
    ),
    of(
        "restless_t",
        "T ← T + (max(restless_t, T) − T) · q,  q = min(1, u / unrest_full)",
        "More components count as background at flickering pixels: less repetitive motion is foreground, \
         but objects in front of it lose more pixels. 0 is off.",
    ),
    of(
        "unrest_memory",
        "u ← (1 − 1/unrest_memory) · u, + 1/unrest_memory where the verdict under T changed",
        "A pixel counts as flickering for longer, and takes longer to be detected as flickering.",
    ),
    of(
        "unrest_full",
        "q = min(1, u / unrest_full)",
        "A pixel must flicker more before feedback takes full effect.",
    ),
    of(
        "shadow_floor",
        "s = X·μ₁ / ‖μ₁‖²; shadow: τ ≤ s < 1",
        "Only light shadows are removed from the foreground; a lower value also removes darker ones, and \
         dark clothes on a surface of the same hue. 1 is off.",
    ),
    of(
        "light_ceiling",
        "s = X·μ₁ / ‖μ₁‖²; light: 1 < s ≤ light_ceiling",
        "Brighter light patches are removed from the foreground: lamps, camera exposure, but also clothes \
         brighter than a surface of the same hue. 1 is off.",
    ),
    of(
        "shadow_window",
        "removed: even shadow or light pixels in the square ≥ other foreground in it",
        "Uses a larger neighbourhood: small shadows near an object stay foreground, and so do larger \
         shadow-like parts of an object. 0: each pixel is decided alone.",
    ),
    of(
        "shadow_spread",
        "even: σ(s) over 3 × 3 pixels ≤ shadow_spread",
        "Textured objects are also classified as shadow; a lower value keeps more of them, and more \
         shadows on rough ground and soft shadow edges. 1: all pixels are even.",
    ),
    of(
        "shadow_colour",
        "shadow: ‖X − s·μ₁‖ ≤ shadow_colour",
        "Shadows may differ in hue from the surface: tolerates noise and coloured light, but more of \
         clothes similar to the surface is removed.",
    ),
    of(
        "hysteresis",
        "weak match: matched, not foreground, ‖X − μ‖ > hysteresis",
        "Fewer pixels are weak matches: holes and edges of objects similar to the background stay \
         background; a lower value fills them, and objects grow into noise nearby. 0: the mixture alone \
         decides.",
    ),
    of(
        "hysteresis_window",
        "foreground: weak match, and foreground in the square ≥ hysteresis_share",
        "Uses a larger neighbourhood: larger holes are filled, thin parts are not. 0 is off.",
    ),
    of(
        "hysteresis_share",
        "foreground in the square / pixels of the square ≥ hysteresis_share",
        "Requires more foreground around a weak match: above .5 only holes are filled; below .43 straight \
         edges move outward by a pixel at weak matches.",
    ),
    of(
        "median",
        "foreground where more than half of the side × side pixels are",
        "Removes larger specks and closes larger gaps; thin structures such as legs and poles are also \
         removed.",
    ),
    of(
        "opening",
        "mask ← dilate(erode(mask, D), D), D a disc as wide as this",
        "Removes thicker bridges and specks and separates touching regions. Structures thinner than the \
         disc are removed.",
    ),
    of(
        "closing",
        "mask ← erode(dilate(mask, D), D), D a disc as wide as this",
        "Closes wider gaps; close regions are joined.",
    ),
    of(
        "fill_holes",
        "hole: background that foreground encloses; filled: area ≤ fill_holes",
        "Larger holes in a region become foreground: clothes of the background's colour, but also gaps \
         between arm and body.",
    ),
    of(
        "min_area",
        "removed: area < min_area",
        "More specks are removed; small and distant objects are, too.",
    ),
    of(
        "track_min_area",
        "tracked: area ≥ track_min_area / 100 · width · height",
        "Fewer small regions are tracked: less noise, but distant objects are detected later.",
    ),
    of(
        "fragment_gap",
        "joined: gap ≤ fragment_gap · longer side, one above the other; or gap ≤ fragment_gap · √area, a small region beside a large one",
        "Bridges wider gaps in the mask of one object, so that it stays one detection; objects close to \
         each other may be joined.",
    ),
    of(
        "gate",
        "d² = rᵀ · S⁻¹ · r ≤ χ²(gate, 3)",
        "Regions farther from the predicted position can be associated; in a crowd the wrong one may be.",
    ),
    of(
        "process_noise",
        "x ← F·x,  P ← F·P·Fᵀ + Q,  Q = diag(q², q², q², q²/4, q²/4, q²/4)",
        "Predictions rely less on constant velocity: turns are followed, and gates grow faster while \
         coasting.",
    ),
    of(
        "measurement_noise",
        "S = H·P·Hᵀ + r²·I",
        "Measured positions have less influence: tracks are smoother and respond later.",
    ),
    of(
        "fitness_memory",
        "e ← e + (d² − e) / fitness_memory,  fitness = 1 / max(e, 3)",
        "A single bad frame has less influence; a model that predicts badly is detected later.",
    ),
    of(
        "null_factor",
        "no match: fitness ← null_factor^min(25 / fps, 5/3) · fitness",
        "A hypothesis loses less fitness per frame without a region, and its object is lost later.",
    ),
    of(
        "min_fitness",
        "removed: fitness < min_fitness",
        "Hypotheses that predict badly are removed sooner, and objects without a region are lost sooner.",
    ),
    of(
        "max_hypotheses",
        "hypotheses of all objects ≤ max_hypotheses, least likely removed first",
        "More alternative associations are kept in a crowd; costs time.",
    ),
    of(
        "min_track",
        "confirmed: detections ≥ min_track",
        "Short-lived noise gets no identity; briefly visible objects do not either.",
    ),
    of(
        "max_hidden",
        "removed: frames without a region > max_hidden",
        "Occluded objects are kept longer; another object that appears there may get their identity.",
    ),
    of(
        "same_episode",
        "same episode: frames separated ≤ same_episode",
        "Objects that separate briefly stay in one episode. Splits and reappearances are reported only \
         after this time.",
    ),
    of(
        "border",
        "near: distance of the box to the edge ≤ border / 100 · min(width, height)",
        "A wider image border counts as entry and exit area: fewer appear and disappear events, more enter \
         and exit events.",
    ),
    of(
        "size_step",
        "grown: area ≥ (1 + size_step) · area before;  shrunk: area ≤ (1 − size_step) · Σ area of the members",
        "Merges and splits require a larger change of area if the position is not conclusive.",
    ),
    of(
        "same_colour",
        "ΔE = ‖Lab₁ − Lab₂‖ ≤ same_colour",
        "Less similar colours count as the same: identities survive changes of light, but objects are \
         confused more often. If colours come from unoccluded frames, full histograms have more weight.",
    ),
    of(
        "colour_memory",
        "clear: h ← h + max(0.1, 1/n) · (h_t − h), n clear frames;  frame: h = h_t",
        "clear: average over the frames in which the object is alone and fully visible. frame: the last \
         single frame, as in the paper.",
    ),
    of(
        "reappear_by",
        "position: min distance / reach;  colour: max similarity with distance ≤ reach, or on the predicted path and similar",
        "position: the object predicted nearest reappears, as in the paper. colour: colours decide between \
         several candidates; an object that stopped or turned while occluded reappears if its colours \
         match.",
    ),
    of(
        "placing",
        "looks: c = argmax Σ ln p(colours | c) − ‖c − c_predicted‖² / 2u²",
        "looks: the remembered appearance of the members is moved over the group's region until it \
         explains the region's colours best. predicted: by predicted motion only, limited to the region.",
    ),
    of(
        "find_again",
        "joins a region: visible share in its unexplained pixels ≥ 0.4",
        "on: an occluded or undetected object joins the region in which it is visible next to the region's \
         own objects. off: it reappears only with a region of its own. Requires placing = looks, which \
         stores the appearance.",
    ),
    of(
        "count_heads",
        "two: gap between heads ≥ 0.13 · height, each with width 0.24–0.8 · height",
        "on: two heads with a gap, each above feet, for half a second are two objects, even if the region \
         never splits. off: a region holds as many objects as entered it.",
    ),
    of(
        "perspective",
        "h = h₀ · exp(b · (y − y₀)), y of the centre, b learnt from all, ½ ≤ h / h₀ ≤ 2",
        "on: the remembered size depends on the position; camera motion or tilt makes b wrong. off: \
         objects keep the size of their last detection.",
    ),
    of(
        "predict_for",
        "shown: frames without detection ≤ predict_for",
        "Predicted positions of undetected objects are drawn and exported for longer; after one second \
         most of them are wrong.",
    ),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{Kind, SETTINGS};

    #[test]
    fn every_setting_has_help_with_a_rule_and_the_effect_of_a_change() {
        let named: Vec<_> = HELP.iter().map(|help| help.name).collect();
        let settings: Vec<_> = SETTINGS.iter().map(|setting| setting.name).collect();
        assert_eq!(named, settings);
        for help in HELP {
            assert!(!help.equation.is_empty(), "{} has no rule", help.name);
            assert!(
                help.raising.len() > 20 && help.raising.ends_with('.'),
                "{}: {}",
                help.name,
                help.raising
            );
        }
    }

    #[test]
    fn the_help_names_every_option() {
        for setting in SETTINGS {
            let (Kind::Choice(words), Some(help)) = (setting.kind, help(setting.name)) else { continue };
            for word in words {
                let explained = help.raising.split(". ").any(|sentence| {
                    sentence
                        .split_once(':')
                        .is_some_and(|(names, _)| names.split(", ").any(|name| name == *word))
                });
                assert!(explained, "{}: what does {word} do?", setting.name);
            }
        }
    }
}
