//! What a setting does: where it stands in the method's equations, and what a greater value changes.

/// The help on one setting.
pub(crate) struct Help {
    /// Its name in the table of settings.
    name: &'static str,
    /// Its equation or rule, empty where it has none.
    pub(crate) equation: &'static str,
    /// What raising it does, or what choosing otherwise does.
    pub(crate) raising: &'static str,
}

/// The help on the setting of this name, if there is any.
pub(crate) fn help(name: &str) -> Option<&'static Help> {
    HELP.iter().find(|help| help.name == name)
}

const fn of(name: &'static str, equation: &'static str, raising: &'static str) -> Help {
    Help { name, equation, raising }
}

static HELP: &[Help] = &[
    of(
        "k",
        "P(X) = Σ w_k · η(X; μ_k, σ_k²), k = 1..K",
        "More surfaces a pixel can remember at once: swaying leaves, glints, a lamp that flashes. It costs time, \
         and rare foreground may stay remembered longer.",
    ),
    of(
        "alpha",
        "w_k ← (1 − α) · w_k + α · M_k",
        "The model learns faster: light is followed sooner, and what stops moving becomes background sooner. It \
         forgets in about 1/α frames.",
    ),
    of(
        "t",
        "B = smallest b with w_1 + … + w_b > T",
        "More components count as background: repeated motion is absorbed, and what stands still for a while is, \
         too. A small T leaves the one strongest.",
    ),
    of(
        "match_sigmas",
        "matched: ‖X − μ‖² ≤ λ² · σ²",
        "A value may be farther from a component's mean and still match it: less noise, but foreground that \
         resembles the background is missed.",
    ),
    of(
        "initial_sigma",
        "new component: (w₀, X, σ₀²)",
        "New components are wider at first: they catch more of a noisy surface at once, and neighbours in colour \
         with it.",
    ),
    of(
        "initial_weight",
        "new component: (w₀, X, σ₀²)",
        "A new surface needs fewer frames to become background.",
    ),
    of(
        "min_sigma",
        "σ² ← max(σ², σ_min²)",
        "Noise, compression and soft shadows are held off; foreground close to the background's colour is missed.",
    ),
    of(
        "rate",
        "μ ← (1 − ρ)μ + ρX;  σ² ← (1 − ρ)σ² + ρ‖X − μ‖²",
        "density: ρ = α · η(X; μ, σ²), the paper's, hardly moves in 8-bit colour. weight: ρ = α / w, fast while a \
         component is young. constant: ρ = α.",
    ),
    of(
        "space",
        "‖X − μ‖² = Σ (X_c − μ_c)², over the n channels",
        "gray sees brightness alone: faster, and blind to colours of equal brightness.",
    ),
    of(
        "warm_up",
        "t ≤ warm_up: α ← max(α, 1/t)",
        "The first frames are averaged for longer, so that somebody who walks in the first one does not stay.",
    ),
    of(
        "shadow_floor",
        "s = X·μ₁ / ‖μ₁‖²; shadow: τ ≤ s < 1",
        "Only light shadows are taken out of the foreground; lower takes darker ones, and dark clothes before a \
         surface of the same hue. 1 takes none.",
    ),
    of(
        "shadow_colour",
        "shadow: ‖X − s·μ₁‖ ≤ shadow_colour",
        "Shadow may be of another hue than the surface: noise and coloured light are allowed for, and more of the \
         clothes that are like the surface is lost.",
    ),
    of(
        "background_model",
        "",
        "mog2 and knn are OpenCV's models in the mixture's place: the stages after it stay, but there is no mixture \
         to inspect.",
    ),
    of(
        "median",
        "foreground where more than half of the side × side pixels are",
        "Larger specks go and larger gaps close; thin things such as legs and poles go, too.",
    ),
    of(
        "opening",
        "erosion, then dilation",
        "Thicker bridges and specks go; regions that only touch come apart.",
    ),
    of("closing", "dilation, then erosion", "Wider gaps close; neighbours that are apart become one region."),
    of("fill_holes", "", "Larger holes inside a region count as foreground."),
    of("min_area", "", "More specks are dropped; small and far objects are, too."),
    of("track_min_area", "", "Fewer small regions are tracked: less noise, and far objects appear later."),
    of(
        "gate",
        "d² = rᵀ · S⁻¹ · r ≤ χ²(gate, 3)",
        "A region may lie farther from where an object was predicted and still belong to it; in a crowd it may then \
         be the wrong one.",
    ),
    of(
        "process_noise",
        "x ← F·x,  P ← F·P·Fᵀ + Q(q)",
        "Predictions trust steady motion less: turns are followed, and gates grow faster while nothing is measured.",
    ),
    of(
        "measurement_noise",
        "S = H·P·Hᵀ + r²·I",
        "A measured place is trusted less: paths become smoother and answer later.",
    ),
    of(
        "fitness_memory",
        "fitness = 1 / mean d²",
        "One bad frame counts less; a lost object is noticed later.",
    ),
    of("null_factor", "no match: fitness ← null_factor · fitness", "Unmatched models live longer."),
    of(
        "min_fitness",
        "removed: fitness < min_fitness",
        "Bad models go sooner; objects break off more easily.",
    ),
    of("max_hypotheses", "", "More readings of a crowd are kept side by side; it costs time."),
    of("min_track", "", "Short-lived noise gets no identity; objects seen briefly get none either."),
    of(
        "max_hidden",
        "",
        "Hidden objects are waited for longer; a stranger who comes out there may be taken for them.",
    ),
    of("same_episode", "", "Objects that part for a moment are still in one meeting."),
    of("border", "", "More of the image's rim counts as a way in or out: less disappears, more exits."),
    of(
        "size_step",
        "merge: Δsize / size ≥ size_step",
        "A merge or split needs a clearer change of size to be believed.",
    ),
    of(
        "same_colour",
        "ΔE = ‖Lab₁ − Lab₂‖ ≤ same_colour",
        "More unlike colours count as the same: identities survive changes of light, and strangers are confused.",
    ),
    of(
        "colour_memory",
        "",
        "clear: an object's colours are averaged over the frames in which it is alone. frame: the last single frame, \
         as in the paper.",
    ),
    of(
        "placing",
        "",
        "looks: members of a group are laid over one another as they are remembered, place by place, and moved until \
         they explain the region's colours best. predicted: their motion alone, held inside the region.",
    ),
    of(
        "find_again",
        "",
        "Somebody hidden, or unseen in a group, joins the region in which their looks explain what its own objects \
         do not.",
    ),
    of(
        "count_heads",
        "",
        "Two heads with a gap between, each above feet, are two objects, though the region never parts.",
    ),
    of(
        "perspective",
        "ln h grows by a slope learnt from all, for each pixel that the feet stand lower",
        "The remembered size follows the place; a camera that moves or tilts makes the slope wrong.",
    ),
    of(
        "predict_for",
        "",
        "Longer draws, and exports, where somebody unseen may be; most such places are wrong after a second.",
    ),
    of("reappear_by", "", "colour: colours decide between several that fit. position: the prediction alone."),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{SETTINGS, Setting, Stage};

    #[test]
    fn the_help_is_on_settings_that_there_are_each_once() {
        for (place, help) in HELP.iter().enumerate() {
            assert!(Setting::named(help.name).is_some(), "{} is no setting", help.name);
            assert!(HELP[place + 1..].iter().all(|other| other.name != help.name), "{} twice", help.name);
            assert!(help.raising.ends_with('.'), "{}", help.raising);
        }
    }

    #[test]
    fn the_mixture_s_settings_all_have_their_help() {
        for setting in SETTINGS.iter().filter(|setting| setting.stage == Stage::Mixture) {
            assert!(help(setting.name).is_some(), "{}", setting.name);
        }
    }
}
