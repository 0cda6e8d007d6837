//! What a setting does: where it stands in the method's equations, and what a greater value changes.

/// The help on one setting.
pub(crate) struct Help {
    /// Its name in the table of settings.
    name: &'static str,
    /// Its equation or rule.
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

/// In the order of the table of settings.
static HELP: &[Help] = &[
    of(
        "stabilise",
        "X(p) = I(A·p + d), A and d from points of strong contrast",
        "off: frames stay as they are. shift, similarity: what the camera's shake moves comes back to its place, and edges \
         are foreground no more; what comes in from outside the frame is background and is not learnt. auto: similarity, \
         once a shake was seen. It costs time where the camera shakes, and nothing where it stands still.",
    ),
    of(
        "light",
        "X = (I − o) / g, g and o of each channel",
        "off: all light is left to the mixture. gain: a cloud or a camera's own exposure is no foreground, where most of \
         the image changes alike. Slow changes and those of less than 4 % are left to the mixture.",
    ),
    of(
        "background_model",
        "mog2, knn: history = 1/α frames; mog2: K and T as here",
        "mixture: the method's own, which can be looked into at every pixel. mog2, knn: OpenCV's models in its \
         place: the stages after it stay, but there is no mixture to inspect.",
    ),
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
        "nothing matched: the last component ← (w₀, X, σ₀²)",
        "New components are wider at first: they catch more of a noisy surface at once, and neighbours in colour \
         with it.",
    ),
    of(
        "initial_weight",
        "nothing matched: the last component ← (w₀, X, σ₀²), then w_k ← w_k / Σ w",
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
        "rgb: n = 3, red, green and blue. gray: n = 1, brightness alone: faster, and blind to colours of equal \
         brightness.",
    ),
    of(
        "warm_up",
        "t ≤ warm_up: α ← max(α, 1/t)",
        "The first frames are averaged for longer, so that somebody who walks in the first one does not stay.",
    ),
    of(
        "bootstrap",
        "frames 1..N first, α ← max(α, 1/t); then w₁ ← 1, component 1 alone, and frame 1 again at t = N + 1",
        "More is known of the background when frame 1 is judged: who stands in it is foreground and leaves no ghost, \
         if he does not stay for most of this time. Other settings of the mixture take longer to show. A camera has none.",
    ),
    of(
        "hold",
        "foreground for more than hold_after frames: α ← hold · α",
        "Foreground that stays is learned faster: a parked car, or the ghost that one leaves, is background sooner, \
         and so is a person who stands still. 1 makes no difference.",
    ),
    of(
        "hold_after",
        "foreground for more than hold_after frames: α ← hold · α",
        "Foreground has to last for longer until it is learned slowly: more of what sways is absorbed, and more of \
         what passes is learned on the way.",
    ),
    of(
        "restless_learning",
        "foreground for 1 to hold_after frames: α ← (1 + (restless_learning − 1) · q) · α",
        "Where the verdict flickers, what is seen for a few frames at a time becomes background sooner: leaves, \
         water, a lamp. 1 makes no difference.",
    ),
    of(
        "restless_t",
        "T ← T + (max(restless_t, T) − T) · q,  q = min(1, u / unrest_full)",
        "Where the verdict flickers, more components count as background: less of what sways is foreground, and \
         objects in front of it lose more. 0 makes no difference.",
    ),
    of(
        "unrest_memory",
        "u ← (1 − 1/unrest_memory) · u, + 1/unrest_memory where the verdict under T changed",
        "A pixel stays restless for longer after it has flickered, and takes longer to be called so.",
    ),
    of(
        "unrest_full",
        "q = min(1, u / unrest_full)",
        "A pixel has to flicker more until feedback acts on it in full.",
    ),
    of(
        "shadow_floor",
        "s = X·μ₁ / ‖μ₁‖²; shadow: τ ≤ s < 1",
        "Only light shadows are taken out of the foreground; lower takes darker ones, and dark clothes before a \
         surface of the same hue. 1 takes none.",
    ),
    of(
        "light_ceiling",
        "s = X·μ₁ / ‖μ₁‖²; light: 1 < s ≤ light_ceiling",
        "Stronger light is taken out of the foreground: lamps, a camera that adapts; and clothes that are brighter than \
         a surface of the same hue. 1 takes none.",
    ),
    of(
        "shadow_window",
        "shadow and light leave the mask: their even pixels in the square ≥ other foreground in it",
        "Neighbours are counted over a wider area: small shadows beside an object stay foreground, and so do larger \
         patches of an object that look like one. 0: each pixel is decided alone.",
    ),
    of(
        "shadow_spread",
        "even: σ(s) over 3 × 3 pixels ≤ shadow_spread",
        "Objects with a pattern of their own are taken for shadow, too; lower keeps more of them, and leaves more of \
         shadows on rough ground and of their soft edges. 1: everything is even.",
    ),
    of(
        "shadow_colour",
        "shadow: ‖X − s·μ₁‖ ≤ shadow_colour",
        "Shadow may be of another hue than the surface: noise and coloured light are allowed for, and more of the \
         clothes that are like the surface is lost.",
    ),
    of(
        "hysteresis",
        "doubtful: matched, not foreground, ‖X − μ‖ > hysteresis",
        "Fewer pixels are doubtful: holes and edges of objects that resemble the background stay background; lower fills \
         them, and objects grow into noise beside them. 0: the mixture alone decides.",
    ),
    of(
        "hysteresis_window",
        "foreground: doubtful, and foreground in the square ≥ hysteresis_share",
        "Neighbours are counted over a wider area: larger holes are filled, thin parts are not. 0 is off.",
    ),
    of(
        "hysteresis_share",
        "foreground in the square / pixels of the square ≥ hysteresis_share",
        "More foreground has to be around a doubtful pixel: above .5 holes alone are filled; below .43 straight edges \
         move outward by a pixel where they are doubtful.",
    ),
    of(
        "median",
        "foreground where more than half of the side × side pixels are",
        "Larger specks go and larger gaps close; thin things such as legs and poles go, too.",
    ),
    of(
        "opening",
        "mask ← dilate(erode(mask, D), D), D a disc as wide as this",
        "Thicker bridges and specks go; regions that only touch come apart. What is thinner than the disc goes.",
    ),
    of(
        "closing",
        "mask ← erode(dilate(mask, D), D), D a disc as wide as this",
        "Wider gaps close; neighbours that are apart become one region.",
    ),
    of(
        "fill_holes",
        "hole: background that foreground encloses; filled: area ≤ fill_holes",
        "Larger holes inside a region count as foreground: clothes of the background's colour, but also what is \
         seen between an arm and the body.",
    ),
    of("min_area", "dropped: area < min_area", "More specks are dropped; small and far objects are, too."),
    of(
        "track_min_area",
        "followed: area ≥ track_min_area / 100 · width · height",
        "Fewer small regions are tracked: less noise, and far objects appear later.",
    ),
    of(
        "fragment_gap",
        "joined: gap ≤ fragment_gap · longer side, one above the other; or gap ≤ fragment_gap · √area, a small region beside a large one",
        "Wider gaps in the mask of one object are bridged, so that it stays one detection; objects close to each other \
         may become one.",
    ),
    of(
        "gate",
        "d² = rᵀ · S⁻¹ · r ≤ χ²(gate, 3)",
        "A region may lie farther from where an object was predicted and still belong to it; in a crowd it may then \
         be the wrong one.",
    ),
    of(
        "process_noise",
        "x ← F·x,  P ← F·P·Fᵀ + Q,  Q = diag(q², q², q², q²/4, q²/4, q²/4)",
        "Predictions trust steady motion less: turns are followed, and gates grow faster while nothing is measured.",
    ),
    of(
        "measurement_noise",
        "S = H·P·Hᵀ + r²·I",
        "A measured place is trusted less: paths become smoother and answer later.",
    ),
    of(
        "fitness_memory",
        "e ← e + (d² − e) / fitness_memory,  fitness = 1 / max(e, 3)",
        "One bad frame counts less; a model that has begun to predict badly is noticed later.",
    ),
    of(
        "null_factor",
        "no match: fitness ← null_factor^min(25 / fps, 5/3) · fitness",
        "A model without its region loses less of its fitness in each frame, and its object counts as lost later.",
    ),
    of(
        "min_fitness",
        "removed: fitness < min_fitness",
        "Hypotheses that predict badly go sooner, and an object whose region is gone counts as lost sooner.",
    ),
    of(
        "max_hypotheses",
        "hypotheses of all objects together ≤ max_hypotheses, those of the least likelihood go first",
        "More readings of a crowd are kept side by side; it costs time.",
    ),
    of(
        "min_track",
        "gets an identity: frames seen ≥ min_track",
        "Short-lived noise gets no identity; objects seen briefly get none either.",
    ),
    of(
        "max_hidden",
        "given up: frames without a region > max_hidden",
        "Hidden objects are waited for longer; a stranger who comes out there may be taken for them.",
    ),
    of(
        "same_episode",
        "the same meeting: frames apart ≤ same_episode",
        "Objects that part for a moment are still in one meeting. That somebody parted or came back is told only \
         after so long.",
    ),
    of(
        "border",
        "near: distance of the box to the edge ≤ border / 100 · min(width, height)",
        "More of the image's rim counts as a way in or out: less appears and disappears, more enters and exits.",
    ),
    of(
        "size_step",
        "grown: area ≥ (1 + size_step) · area before;  shrunk: area ≤ (1 − size_step) · Σ area of the members",
        "A merge or split needs a clearer change of size to be believed where the place alone does not decide.",
    ),
    of(
        "same_colour",
        "ΔE = ‖Lab₁ − Lab₂‖ ≤ same_colour",
        "More unlike colours count as the same: identities survive changes of light, and strangers are confused. \
         Where colours come from clear frames, whole histograms weigh more than this.",
    ),
    of(
        "colour_memory",
        "clear: h ← h + max(0.1, 1/n) · (h_t − h), n clear frames;  frame: h = h_t",
        "clear: an object's colours are averaged over the frames in which it is alone and whole. frame: those of the \
         last single frame, as in the paper.",
    ),
    of(
        "reappear_by",
        "position: least distance / reach;  colour: most like, of those with distance ≤ reach, or on their way and alike",
        "position: who was predicted nearest comes back, as in the paper. colour: where several were predicted near, \
         colours decide between them; and who stopped or turned while hidden comes back if their colours agree.",
    ),
    of(
        "placing",
        "looks: c = argmax Σ ln p(colours | c) − ‖c − c_predicted‖² / 2u²",
        "looks: members of a group are laid over one another as they are remembered, place by place, and moved until \
         they explain the region's colours best. predicted: their motion alone, held inside the region.",
    ),
    of(
        "find_again",
        "joins a region: share of them seen in what its own objects do not explain ≥ 0.4",
        "on: somebody hidden, or unseen in a group, joins the region in which they are seen beside its own objects. \
         off: they come back only with a region of their own. It needs placing = looks, which keeps how they look.",
    ),
    of(
        "count_heads",
        "two: a gap between heads ≥ 0.13 · height, each 0.24 to 0.8 times as wide as tall",
        "on: two heads with a gap between, each above feet, for half a second are two objects, though the region \
         never parts. off: a region is as many objects as came into it.",
    ),
    of(
        "perspective",
        "h = h₀ · exp(b · (y − y₀)), y of the feet, b learnt from all, ½ ≤ h / h₀ ≤ 2",
        "on: the remembered size follows the place; a camera that moves or tilts makes b wrong. off: everybody stays \
         as large as they were last seen.",
    ),
    of(
        "predict_for",
        "told: frames unseen ≤ predict_for",
        "Longer draws, and exports, where somebody unseen may be; most such places are wrong after a second.",
    ),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{Kind, SETTINGS};

    #[test]
    fn every_setting_has_its_help_with_a_rule_and_what_a_change_does() {
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
    fn each_choice_is_told_from_the_others() {
        for setting in SETTINGS {
            let (Kind::Choice(words), Some(help)) = (setting.kind, help(setting.name)) else { continue };
            for word in words {
                let told = help.raising.split(". ").any(|sentence| {
                    sentence
                        .split_once(':')
                        .is_some_and(|(names, _)| names.split(", ").any(|name| name == *word))
                });
                assert!(told, "{}: what does {word} do?", setting.name);
            }
        }
    }
}
