// Composes one view from the layers of a frame. A texel is one pixel of the image, or every n-th
// one of an image that is too large for the card.

struct ViewUniforms {
    // The image's upper left corner and the window's size, in pixels of the screen.
    origin: vec2<f32>,
    screen: vec2<f32>,
    // The image's size in pixels of the screen.
    extent: vec2<f32>,
    // Width and height in texels.
    texels: vec2<f32>,
    // The colour over foreground, and its opacity, 0 to 1.
    overlay: vec4<f32>,
    // The colour scale: 0 for steps, 1 for linear, 2 for logarithmic; the offset; the values of the darkest and the
    // brightest colour.
    numbers: vec4<f32>,
    // Screen pixels per texel, in width and height.
    scale: vec2<f32>,
    // All colours are multiplied by this.
    tint: f32,
    // Screen pixels per point.
    dense: f32,
    // The colour of pixels that are foreground only in the other mask, or only in the ground truth.
    other_colour: vec4<f32>,
}

@group(0) @binding(0) var<uniform> view: ViewUniforms;
@group(0) @binding(1) var smooth_sampler: sampler;

@group(1) @binding(0) var input: texture_2d<f32>;
@group(1) @binding(1) var mean: texture_2d<f32>;
@group(1) @binding(2) var modes: texture_2d<f32>;
@group(1) @binding(3) var map: texture_2d<f32>;
@group(1) @binding(4) var mask: texture_2d<f32>;
@group(1) @binding(5) var labels: texture_2d<u32>;
@group(1) @binding(6) var palette: texture_2d<f32>;
@group(1) @binding(7) var ignored: texture_2d<f32>;
@group(1) @binding(8) var compared_mean: texture_2d<f32>;
@group(1) @binding(9) var compared_mask: texture_2d<f32>;
// Foreground in the ground truth, and pixels that are not ignored.
@group(1) @binding(10) var truth: texture_2d<f32>;
@group(1) @binding(11) var external_mask: texture_2d<f32>;

// The kind of composition, in the order of `Compose`. It is a constant and not a uniform: software adapters execute all
// branches of a condition that is unknown when the shader is built.
override WHAT: u32 = 0u;
const INPUT: u32 = 0u;
const MASKED: u32 = 1u;
const MEAN: u32 = 2u;
const MODES: u32 = 3u;
const MAP: u32 = 4u;
const MASK: u32 = 5u;
const REGIONS: u32 = 6u;
const DIFFERENCE: u32 = 7u;
const COMPARED_MEAN: u32 = 8u;
const COMPARED_MASK: u32 = 9u;
const AGREEMENT: u32 = 10u;
const MASK_ERRORS: u32 = 11u;
const EXTERNAL_AGREEMENT: u32 = 12u;
const EXTERNAL_ERRORS: u32 = 13u;

// The colour of ignored pixels.
const IGNORED = vec3<f32>(58.0, 52.0, 66.0) / 255.0;

// The colour of pixels that are foreground in both masks.
const BOTH = vec3<f32>(228.0, 232.0, 238.0) / 255.0;

// Number of colours of the ramp in the palette's first row, and of the steps in its second.
const RAMP: u32 = 255u;
const STEPS: u32 = 6u;

// Maximum number of texels per screen pixel and direction that are read where texels are smaller.
const MOST_TEXELS: f32 = 64.0;

@vertex
fn corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let at = view.origin + view.extent * vec2<f32>(f32(index & 1u), f32(index >> 1u));
    return vec4<f32>(2.0 * at.x / view.screen.x - 1.0, 1.0 - 2.0 * at.y / view.screen.y, 0.0, 1.0);
}

// BT.601 in 8 bits.
fn luma(colour: vec3<f32>) -> f32 {
    let c = vec3<u32>(colour * 255.0 + 0.5);
    return f32((9798u * c.r + 19235u * c.g + 3735u * c.b + 16384u) >> 15u);
}

fn masked(input_here: vec3<f32>, mask_here: f32) -> vec3<f32> {
    return mix(input_here, view.overlay.rgb, view.overlay.a * mask_here);
}

fn difference(input_here: vec3<f32>, mean_here: vec3<f32>) -> vec3<f32> {
    let channels = abs(input_here - mean_here);
    return vec3<f32>(min(2.0 * max(channels.r, max(channels.g, channels.b)), 1.0));
}

// The colour of a value on the colour scale. Values below 0 stand for infinite ones.
fn of_number(value: f32) -> vec4<f32> {
    if value < 0.0 {
        return textureLoad(palette, vec2<u32>(RAMP, 0u), 0);
    }
    if view.numbers.x == 0.0 {
        return textureLoad(palette, vec2<u32>(min(u32(value), STEPS - 1u), 1u), 0);
    }
    var along = value + view.numbers.y;
    if view.numbers.x == 2.0 {
        along = log2(along);
    }
    let share = clamp((along - view.numbers.z) / (view.numbers.w - view.numbers.z), 0.0, 1.0);
    return textureLoad(palette, vec2<u32>(u32(share * f32(RAMP - 1u) + 0.5), 0u), 0);
}

// The colour of a map's value, or of a region, at a texel; alpha is 0 where there is no region.
fn named(at: vec2<i32>) -> vec4<f32> {
    if WHAT == MAP {
        return of_number(textureLoad(map, at, 0).r);
    }
    let label = textureLoad(labels, at, 0).r;
    if label == 0u {
        return vec4<f32>(0.0);
    }
    return textureLoad(palette, vec2<u32>(label & 255u, 2u + (label >> 8u)), 0);
}

// Regions in their colours over a dark input. A fraction of the input's luma keeps their inside recognisable.
fn over_dark(region: vec4<f32>, input_here: vec3<f32>) -> vec3<f32> {
    let gray = luma(input_here);
    let ground = floor(gray / 4.0) / 255.0;
    let lit = floor(region.rgb * (255.0 * 0.55 + 0.45 * gray) + 0.001) / 255.0;
    return lit + ground * (1.0 - region.a);
}

// Pixels of one mask, the other or both over a dark input; each argument is a share of foreground.
fn agreement(mask_here: f32, compared_here: f32, input_here: vec3<f32>) -> vec3<f32> {
    let both = mask_here * compared_here;
    let first = mask_here - both;
    let second = compared_here - both;
    let gray = luma(input_here) / 255.0;
    let named = BOTH * both + view.overlay.rgb * first + view.other_colour.rgb * second;
    return named * (0.75 + 0.25 * gray) + 0.3 * gray * (1.0 - both - first - second);
}

// The mask against the ground truth; ignored pixels have one dark colour.
fn mask_errors(mask_here: f32, truth_here: vec2<f32>, input_here: vec3<f32>) -> vec3<f32> {
    return mix(IGNORED, agreement(min(mask_here, truth_here.y), truth_here.x, input_here), truth_here.y);
}

fn texel(at: vec2<i32>) -> vec3<f32> {
    switch WHAT {
        case MASKED: { return masked(textureLoad(input, at, 0).rgb, textureLoad(mask, at, 0).r); }
        case MEAN: { return textureLoad(mean, at, 0).rgb; }
        case MODES: { return textureLoad(modes, at, 0).rgb; }
        case MAP: { return named(at).rgb; }
        case MASK: { return vec3<f32>(textureLoad(mask, at, 0).r); }
        case REGIONS: { return over_dark(named(at), textureLoad(input, at, 0).rgb); }
        case DIFFERENCE: { return difference(textureLoad(input, at, 0).rgb, textureLoad(mean, at, 0).rgb); }
        case COMPARED_MEAN: { return textureLoad(compared_mean, at, 0).rgb; }
        case COMPARED_MASK: { return vec3<f32>(textureLoad(compared_mask, at, 0).r); }
        case AGREEMENT: {
            let compared_here = textureLoad(compared_mask, at, 0).r;
            return agreement(textureLoad(mask, at, 0).r, compared_here, textureLoad(input, at, 0).rgb);
        }
        case MASK_ERRORS: {
            let truth_here = textureLoad(truth, at, 0).rg;
            return mask_errors(textureLoad(mask, at, 0).r, truth_here, textureLoad(input, at, 0).rgb);
        }
        case EXTERNAL_AGREEMENT: {
            let external_here = textureLoad(external_mask, at, 0).r;
            return agreement(textureLoad(mask, at, 0).r, external_here, textureLoad(input, at, 0).rgb);
        }
        case EXTERNAL_ERRORS: {
            let truth_here = textureLoad(truth, at, 0).rg;
            return mask_errors(textureLoad(external_mask, at, 0).r, truth_here, textureLoad(input, at, 0).rgb);
        }
        default: { return textureLoad(input, at, 0).rgb; }
    }
}

// Minified, a pixel of the screen gets the mean of the texels under it, each by the share of the pixel that it
// covers: no line is too thin to be seen, and none flickers while the image moves.
struct Under {
    low: vec2<f32>,
    high: vec2<f32>,
    first: vec2<f32>,
    // 1, or more where there are too many to look at each.
    stride: vec2<f32>,
};

fn under(middle: vec2<f32>) -> Under {
    let low = max(middle - 0.5 / view.scale, vec2<f32>(0.0));
    let high = min(middle + 0.5 / view.scale, view.texels);
    return Under(low, high, floor(low), max((high - low) / MOST_TEXELS, vec2<f32>(1.0)));
}

// Two neighbours and the shares that they have: where between them a smooth sampler weighs them like that, and
// their shares together.
fn pair(low: f32, high: f32, first: f32, stride: f32) -> vec2<f32> {
    let a = max(min(first + stride, high) - max(first, low), 0.0);
    let b = max(min(first + 2.0 * stride, high) - (first + stride), 0.0);
    return vec2<f32>(first + stride * (0.5 + b / max(a + b, 1e-6)), a + b);
}

// The same as `texel` for a mean of up to four of them. Names have no mean: it is the input that regions lie over.
fn smooth_texels(at: vec2<f32>) -> vec3<f32> {
    switch WHAT {
        case MASKED: {
            let mask_here = textureSampleLevel(mask, smooth_sampler, at, 0.0).r;
            return masked(textureSampleLevel(input, smooth_sampler, at, 0.0).rgb, mask_here);
        }
        case MEAN: { return textureSampleLevel(mean, smooth_sampler, at, 0.0).rgb; }
        case MODES: { return textureSampleLevel(modes, smooth_sampler, at, 0.0).rgb; }
        case MASK: { return vec3<f32>(textureSampleLevel(mask, smooth_sampler, at, 0.0).r); }
        case DIFFERENCE: {
            let mean_here = textureSampleLevel(mean, smooth_sampler, at, 0.0).rgb;
            return difference(textureSampleLevel(input, smooth_sampler, at, 0.0).rgb, mean_here);
        }
        case COMPARED_MEAN: { return textureSampleLevel(compared_mean, smooth_sampler, at, 0.0).rgb; }
        case COMPARED_MASK: { return vec3<f32>(textureSampleLevel(compared_mask, smooth_sampler, at, 0.0).r); }
        case AGREEMENT: {
            let mask_here = textureSampleLevel(mask, smooth_sampler, at, 0.0).r;
            let compared_here = textureSampleLevel(compared_mask, smooth_sampler, at, 0.0).r;
            return agreement(mask_here, compared_here, textureSampleLevel(input, smooth_sampler, at, 0.0).rgb);
        }
        case MASK_ERRORS: {
            let mask_here = textureSampleLevel(mask, smooth_sampler, at, 0.0).r;
            let truth_here = textureSampleLevel(truth, smooth_sampler, at, 0.0).rg;
            return mask_errors(mask_here, truth_here, textureSampleLevel(input, smooth_sampler, at, 0.0).rgb);
        }
        case EXTERNAL_AGREEMENT: {
            let mask_here = textureSampleLevel(mask, smooth_sampler, at, 0.0).r;
            let external_here = textureSampleLevel(external_mask, smooth_sampler, at, 0.0).r;
            return agreement(mask_here, external_here, textureSampleLevel(input, smooth_sampler, at, 0.0).rgb);
        }
        case EXTERNAL_ERRORS: {
            let external_here = textureSampleLevel(external_mask, smooth_sampler, at, 0.0).r;
            let truth_here = textureSampleLevel(truth, smooth_sampler, at, 0.0).rg;
            return mask_errors(external_here, truth_here, textureSampleLevel(input, smooth_sampler, at, 0.0).rgb);
        }
        default: { return textureSampleLevel(input, smooth_sampler, at, 0.0).rgb; }
    }
}

fn mean_of(what: Under) -> vec3<f32> {
    var sum = vec4<f32>(0.0);
    for (var y = what.first.y; y < what.high.y; y += 2.0 * what.stride.y) {
        let row = pair(what.low.y, what.high.y, y, what.stride.y);
        for (var x = what.first.x; x < what.high.x; x += 2.0 * what.stride.x) {
            let column = pair(what.low.x, what.high.x, x, what.stride.x);
            sum += vec4<f32>(smooth_texels(vec2<f32>(column.x, row.x) / view.texels), 1.0) * (row.y * column.y);
        }
    }
    return sum.rgb / max(sum.a, 1e-6);
}

fn mean_of_named(what: Under) -> vec4<f32> {
    var sum = vec4<f32>(0.0);
    var shares = 0.0;
    for (var y = what.first.y; y < what.high.y; y += what.stride.y) {
        let height = min(y + what.stride.y, what.high.y) - max(y, what.low.y);
        for (var x = what.first.x; x < what.high.x; x += what.stride.x) {
            let share = height * (min(x + what.stride.x, what.high.x) - max(x, what.low.x));
            sum += named(vec2<i32>(vec2<f32>(x, y) + what.stride / 2.0)) * share;
            shares += share;
        }
    }
    return sum / max(shares, 1e-6);
}

// What is not analysed is darker, under thin diagonal lines.
fn set_back(colour: vec3<f32>, position: vec2<f32>) -> vec3<f32> {
    let at = (position - view.origin) / view.scale;
    var share = 0.0;
    if min(view.scale.x, view.scale.y) >= 1.0 {
        share = textureLoad(ignored, vec2<i32>(clamp(floor(at), vec2<f32>(0.0), view.texels - 1.0)), 0).r;
    } else {
        share = textureSampleLevel(ignored, smooth_sampler, at / view.texels, 0.0).r;
    }
    let along = fract((position.x + position.y) / (9.0 * view.dense));
    let line = select(0.0, 0.16, along < 0.14);
    return mix(colour, colour * 0.38 + line, share);
}

fn composed(position: vec2<f32>) -> vec3<f32> {
    let middle = (position - view.origin) / view.scale;
    if min(view.scale.x, view.scale.y) >= 1.0 {
        return texel(vec2<i32>(clamp(floor(middle), vec2<f32>(0.0), view.texels - 1.0)));
    }
    let what = under(middle);
    switch WHAT {
        case MAP: { return mean_of_named(what).rgb; }
        case REGIONS: { return over_dark(mean_of_named(what), mean_of(what)); }
        default: { return mean_of(what); }
    }
}

@fragment
fn to_gamma(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    return vec4<f32>(set_back(composed(position.xy) * view.tint, position.xy), 1.0);
}

// For a window that takes linear light and makes sRGB of it itself.
@fragment
fn to_linear(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let srgb = set_back(composed(position.xy) * view.tint, position.xy);
    let low = srgb / 12.92;
    let high = pow((srgb + 0.055) / 1.055, vec3<f32>(2.4));
    return vec4<f32>(select(high, low, srgb < vec3<f32>(0.04045)), 1.0);
}
