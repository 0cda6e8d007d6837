//! The mixture: the optimised image implementation against the reference implementation, and invariants for any
//! settings and input.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use occluscope::frame::{Frame, Mask, Size};
use occluscope::mixture::hysteresis::Hysteresis;
use occluscope::mixture::shadow::Shadow;
use occluscope::mixture::{Component, Feedback, Mixture, Parameters, Pixel};
use occluscope::registration::CorrectionChoice;
use occluscope::settings::{Rate, Settings, Space, Span};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

fn parameters() -> impl Strategy<Value = Parameters> {
    let rates = prop_oneof![Just(Rate::Density), Just(Rate::Weight), Just(Rate::Constant)];
    let spaces = prop_oneof![Just(Space::Rgb), Just(Space::Gray)];
    let shadow = prop_oneof![
        Just(Shadow { floor: 1.0, ceiling: 1.0, colour: 0.0, window: 0, spread: 0.07 }),
        (0.2_f32..1.0, 1.0_f32..2.0, 0.0_f32..100.0, prop_oneof![Just(0), Just(3), Just(7)]).prop_map(
            |(floor, ceiling, colour, window)| Shadow { floor, ceiling, colour, window, spread: 0.07 }
        ),
    ];
    let hysteresis = prop_oneof![
        Just(Hysteresis { distance: 0.0, window: 7, share: 0.35 }),
        (0.5_f32..40.0, prop_oneof![Just(3), Just(5), Just(7)], 0.01_f32..0.6)
            .prop_map(|(distance, window, share)| Hysteresis { distance, window, share }),
    ];
    let feedback = prop_oneof![
        Just((1.0, 1.0, 0.0)),
        (0.001_f32..1.0, 1.0_f32..20.0, 0.0_f32..0.99),
        (Just(1.0), Just(1.0), 0.5_f32..0.99),
    ];
    let feedback = (feedback, 1_u16..12, 0.002_f32..0.3, 0.01_f32..0.5).prop_map(
        |((hold, learning, t), hold_after, gain, full)| Feedback {
            hold,
            hold_after: f32::from(hold_after),
            learning,
            t,
            gain,
            full,
        },
    );
    (
        (1_usize..=8, 0.001_f32..0.5, 0.05_f32..0.99, 0.5_f32..6.0),
        (1.0_f32..60.0, 0.005_f32..0.5, 0.1_f32..20.0, rates, spaces, 0_u32..30),
        (shadow, hysteresis, feedback),
    )
        .prop_map(
            |(
                (k, alpha, t, lambda),
                (initial_sigma, initial_weight, min_sigma, rate, space, warm_up),
                (shadow, hysteresis, feedback),
            )| {
                Parameters {
                    k,
                    alpha,
                    t,
                    lambda,
                    initial_sigma,
                    initial_weight,
                    min_sigma,
                    rate,
                    space,
                    warm_up,
                    bootstrap: Span::Frames(0),
                    learnt: 0,
                    shadow,
                    hysteresis,
                    feedback,
                    registration: CorrectionChoice::NOTHING,
                }
            },
        )
}

/// Pixels that mostly show one of two surfaces with noise, and occasionally random values.
fn frames(seed: u64, size: Size, count: u32) -> Vec<Frame> {
    let mut random = Pcg32::seed_from_u64(seed);
    let surfaces: Vec<[[i32; 3]; 2]> = (0..size.pixels())
        .map(|_| [0; 2].map(|_: i32| [0; 3].map(|_: i32| random.random_range(0..256))))
        .collect();
    (1..=count)
        .map(|number| {
            let busy = random.random_range(0..3) == 0;
            let rgb = surfaces.iter().flat_map(|surface| {
                let colour = if busy && random.random_range(0..20) == 0 {
                    [0; 3].map(|_: i32| random.random_range(0..256))
                } else {
                    surface[usize::from(random.random_range(0..8) == 0)]
                };
                colour.map(|channel| (channel + random.random_range(-4..=4)).clamp(0, 255) as u8)
            });
            Frame::new(number, size, rgb.collect())
        })
        .collect()
}

/// All numbers of a pixel as bits.
fn bits(pixel: &Pixel) -> Vec<[u32; 5]> {
    let numbers = |component: &Component| {
        let [r, g, b] = component.mean;
        [component.weight, component.variance, r, g, b].map(f32::to_bits)
    };
    let past = pixel.past();
    let past = [past.run, past.unrest, f32::from(u8::from(past.strict)), 0.0, 0.0].map(f32::to_bits);
    pixel.components().iter().map(numbers).chain([past]).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn the_learned_state_of_the_image_equals_the_reference(
        parameters in parameters(),
        seed in any::<u64>(),
        (width, height) in (1_u32..40, 1_u32..5),
        to_learn in 1_usize..60,
        batches in prop::collection::vec(1_usize..40, 1..20),
        stop in 0_usize..60,
    ) {
        let size = Size::new(width, height);
        let frames = frames(seed, size, 60);
        let mut image = Mixture::new(size, parameters);
        let mut rest = &frames[..to_learn];
        for length in batches.into_iter().cycle() {
            let (batch, later) = rest.split_at(length.min(rest.len()));
            image.learn(&batch.iter().collect::<Vec<_>>());
            rest = later;
            if rest.is_empty() {
                break;
            }
        }
        let parameters = Parameters { learnt: to_learn as u32, ..parameters };
        prop_assert_eq!(image.parameters(), &parameters);
        let mut plain = vec![Pixel::unseen(parameters.k); size.pixels()];
        let value = |frame: &Frame, index: usize| {
            parameters.value(frame.pixel(index as u32 % width, index as u32 / width).unwrap())
        };
        for (t, frame) in (1..).zip(&frames[..to_learn]) {
            for (index, pixel) in plain.iter_mut().enumerate() {
                pixel.update(value(frame, index), t, &parameters);
            }
        }
        // A snapshot can be restored at the start and at any later frame.
        let mut copy = image.clone();
        copy.begin();
        let start = copy.snapshot();
        let mut masks = vec![Mask::empty(size); 60];
        copy.step_many(&frames.iter().collect::<Vec<_>>(), &mut masks);
        prop_assert!(copy.restore(&start));
        for (t, (frame, mask)) in (to_learn as u32 + 1..).zip(frames.iter().zip(&masks)) {
            prop_assert_eq!(&image.step(frame), mask);
            if t as usize <= to_learn + stop {
                prop_assert_eq!(&copy.step(frame), mask);
            }
            for (index, pixel) in plain.iter_mut().enumerate() {
                let outcome = pixel.update(value(frame, index), t, &parameters);
                let (x, y) = (index as u32 % width, index as u32 / width);
                prop_assert_eq!(bits(&image.pixel(x, y).unwrap()), bits(pixel), "pixel {} {} at {}", x, y, t);
                prop_assert!(outcome.foreground || outcome.weak_match || mask.data[index] == Mask::BACKGROUND);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    #[test]
    fn the_image_equals_the_reference_bit_for_bit(
        parameters in parameters(),
        seed in any::<u64>(),
        (width, height) in (1_u32..40, 1_u32..5),
        threads in 1_usize..4,
        batches in prop::collection::vec(1_usize..40, 1..20),
    ) {
        let size = Size::new(width, height);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut image = Mixture::new(size, parameters);
        let mut plain = vec![Pixel::unseen(parameters.k); size.pixels()];
        let frames = frames(seed, size, 60);
        let mut rest = &frames[..];
        // Some frames individually, some in batches of any length.
        for length in batches.into_iter().cycle() {
            let (batch, later) = rest.split_at(length.min(rest.len()));
            let mut masks = vec![Mask { size, data: vec![7; size.pixels()] }; batch.len()];
            if let [frame] = batch {
                masks[0] = pool.install(|| image.step(frame));
            } else {
                pool.install(|| image.step_many(&batch.iter().collect::<Vec<_>>(), &mut masks));
            }
            for (frame, mask) in batch.iter().zip(&masks) {
                // The result of each pixel by itself: `None` for background, the brightness in levels for shadow or
                // highlight, 0 for other foreground; and which pixels are weak_match.
                let mut weak_match = Vec::new();
                let alone: Vec<Option<u32>> = plain
                    .iter_mut()
                    .enumerate()
                    .map(|(index, pixel)| {
                        let (x, y) = (index as u32 % width, index as u32 / width);
                        let value = parameters.value(frame.pixel(x, y).unwrap());
                        let outcome = pixel.update(value, frame.number, &parameters);
                        let channels = if parameters.space == Space::Gray { 1 } else { 3 };
                        let surface = pixel.components()[0].mean;
                        let (value, surface) = (&value[..channels], &surface[..channels]);
                        let covers = parameters.shadow.covers(value, surface);
                        weak_match.push(outcome.weak_match && !covers);
                        outcome.foreground.then(|| {
                            if covers { 1 + (60.0 * parameters.shadow.of(value, surface).0) as u32 } else { 0 }
                        })
                    })
                    .collect();
                let square = |index: usize, reach: i32| {
                    let (x, y) = (index as i32 % width as i32, index as i32 / width as i32);
                    let around = (-reach..=reach).flat_map(|down| (-reach..=reach).map(move |right| (x + right, y + down)));
                    let inside = around.filter(|&(x, y)| (0..width as i32).contains(&x) && (0..height as i32).contains(&y));
                    inside.map(|(x, y)| (y * width as i32 + x) as usize).collect::<Vec<_>>()
                };
                let is_even = |index: usize| {
                    let around = square(index, 1);
                    let levels: Vec<u32> = around.iter().filter_map(|&at| alone[at]).filter(|&level| level > 0).collect();
                    let (n, sum) = (levels.len() as u32, levels.iter().sum::<u32>());
                    let squares: u32 = levels.iter().map(|level| level * level).sum();
                    let most = (n as f32 * parameters.shadow.spread * 60.0).powi(2);
                    2 * levels.len() >= around.len() && (n * squares - sum * sum) as f32 <= most
                };
                let sure: Vec<bool> = (0..alone.len())
                    .map(|index| {
                        let votes = square(index, parameters.shadow.window as i32 / 2).into_iter().map(|at| match alone[at] {
                            None => 0,
                            Some(0) => -1,
                            Some(_) => i32::from(is_even(at)),
                        });
                        match alone[index] {
                            None => false,
                            Some(0) => true,
                            Some(_) => parameters.shadow.window > 0 && votes.sum::<i32>() < 0,
                        }
                    })
                    .collect();
                for index in 0..alone.len() {
                    let around = square(index, parameters.hysteresis.window as i32 / 2);
                    let near = around.iter().filter(|&&at| sure[at]).count() as f32;
                    let joins = weak_match[index] && near >= parameters.hysteresis.share * around.len() as f32;
                    let expected = if sure[index] || joins { Mask::FOREGROUND } else { Mask::BACKGROUND };
                    let (x, y) = (index as u32 % width, index as u32 / width);
                    prop_assert_eq!(mask.data[index], expected, "pixel {} {} in frame {}", x, y, frame.number);
                }
            }
            for (index, pixel) in plain.iter().enumerate() {
                let (x, y) = (index as u32 % width, index as u32 / width);
                prop_assert_eq!(bits(&image.pixel(x, y).unwrap()), bits(pixel), "pixel {} {}", x, y);
            }
            let images = image.background_images();
            prop_assert_eq!(&images.mean, &image.mean_image());
            for (index, pixel) in plain.iter().enumerate() {
                let t = parameters.t_of(pixel.past());
                let rgb = |mean: [f32; 3]| {
                    let gray = parameters.space == Space::Gray;
                    [0, 1, 2].map(|channel| mean[if gray { 0 } else { channel }].round() as u8)
                };
                prop_assert_eq!(&images.mean[3 * index..][..3], rgb(pixel.components()[0].mean));
                prop_assert_eq!(&images.multi_mode[3 * index..][..3], rgb(pixel.background_mean(t)));
                prop_assert_eq!(usize::from(images.background_count[index]), pixel.background_count(t));
            }
            rest = later;
            if rest.is_empty() {
                break;
            }
        }
        prop_assert_eq!(image.frames_seen(), 60);
    }

    #[test]
    fn every_state_is_a_valid_mixture(parameters in parameters(), seed in any::<u64>()) {
        let mut pixel = Pixel::unseen(parameters.k);
        for (frame, t) in frames(seed, Size::new(1, 1), 300).iter().zip(1..) {
            let before = pixel;
            let outcome = pixel.update(parameters.value(frame.pixel(0, 0).unwrap()), t, &parameters);
            let components = pixel.components();
            let past = pixel.past();
            prop_assert!((0.0..=1.0).contains(&past.unrest) && (past.run > 0.0) <= outcome.foreground);
            let sum: f32 = components.iter().map(|component| component.weight).sum();
            prop_assert!((sum - 1.0).abs() < 1e-4, "weights sum to {}", sum);
            prop_assert!((1..=parameters.k as u8).contains(&outcome.rank));
            prop_assert!((1..=parameters.k as u8).contains(&outcome.background_count));
            prop_assert!(outcome.matched <= parameters.k as u8);
            prop_assert!((0.0..=1.0).contains(&outcome.rho));
            prop_assert!(outcome.p >= 0.0 && outcome.p.is_finite());
            prop_assert_eq!(outcome.rho == 0.0 && t > 1, outcome.matched == 0 && t > 1);
            let used = components.iter().take_while(|component| component.weight > 0.0).count();
            for component in &components[..used] {
                prop_assert!(component.sigma() >= parameters.min_sigma.min(parameters.initial_sigma) * 0.999_99);
            }
            for component in &components[used..] {
                // A weight can decay to 0 after hundreds of frames at a large α; an unused component is all zeros;
                // neither is ranked above one in use.
                prop_assert_eq!(component.weight, 0.0);
            }
            // The updated component is ranked according to the neighbour that it passed.
            let rank = usize::from(outcome.rank);
            let started = if outcome.matched > 0 { usize::from(outcome.matched) } else { parameters.k };
            if rank < started {
                prop_assert!(components[rank - 1].rank_value() > components[rank].rank_value());
            }
            if t > 1 && outcome.matched > 0 && rank == usize::from(outcome.matched) && parameters.k > 1 {
                // No component is added; at an α near 1 other weights decay to 0.
                prop_assert!(pixel.used() <= before.used());
            }
        }
    }
}

/// At a large α, weights decay to 0, and a component of weight 0 can be ranked above others.
#[test]
fn faded_components_are_treated_alike() {
    for (k, alpha) in [(3, 0.6), (4, 0.9), (8, 0.8)] {
        let size = Size::new(19, 1);
        let parameters = Parameters { alpha, initial_weight: 0.3, ..plain(k) };
        let frames = frames(5, size, 700);
        let mut image = Mixture::new(size, parameters);
        let mut plain = vec![Pixel::unseen(k); size.pixels()];
        let mut masks = vec![Mask::empty(size); frames.len()];
        image.step_many(&frames.iter().collect::<Vec<_>>(), &mut masks);
        for (frame, mask) in frames.iter().zip(&masks) {
            for (x, pixel) in (0..).zip(&mut plain) {
                let value = parameters.value(frame.pixel(x, 0).unwrap());
                let outcome = pixel.update(value, frame.number, &parameters);
                assert_eq!(
                    mask.is_foreground(x, 0),
                    outcome.foreground,
                    "pixel {x} in frame {}",
                    frame.number
                );
            }
        }
        for (x, pixel) in (0..).zip(&plain) {
            assert_eq!(bits(&image.pixel(x, 0).unwrap()), bits(pixel), "pixel {x}, K {k}");
        }
    }
}

fn grey(number: u32, level: u8) -> Frame {
    Frame::new(number, Size::new(1, 1), vec![level; 3])
}

fn plain(k: usize) -> Parameters {
    Parameters {
        k,
        ..Parameters::new(&occluscope::settings::Settings::preset(occluscope::settings::Preset::Plain))
    }
}

#[test]
fn two_frames_equal_values_computed_by_hand() {
    let parameters = plain(3);
    let mut pixel = Pixel::unseen(3);
    let first = pixel.update([100.0; 3], 1, &parameters);
    assert_eq!((first.matched, first.rank, first.background_count, first.foreground), (0, 1, 1, false));
    assert_eq!((first.rho, first.p), (0.0, 0.0));
    let component = pixel.components()[0];
    assert_eq!((component.weight, component.mean, component.variance), (1.0, [100.0; 3], 400.0));

    // ‖(10, 0, 0)‖² = 100 ≤ 6.25·400. ρ = α/w = .01; μ = 100.1; ‖X − μ‖² = 98.01; σ² = 396 + .9801.
    let second = pixel.update([110.0, 100.0, 100.0], 2, &parameters);
    assert_eq!((second.matched, second.rank, second.foreground), (1, 1, false));
    assert!((second.rho - 0.01).abs() < 1e-7);
    let component = pixel.components()[0];
    assert!((component.mean[0] - 100.1).abs() < 1e-4 && component.mean[1] == 100.0);
    assert!((component.variance - 396.9801).abs() < 1e-3);
    // P = (2π·400)^(-3/2)·e^(-1/8).
    assert!((second.p / 7.003e-6 - 1.0).abs() < 1e-3, "{}", second.p);

    // Far away: a new component of weight w₀ / (.99 + w₀), renormalised; the pixel is foreground.
    let third = pixel.update([255.0; 3], 3, &parameters);
    assert_eq!((third.matched, third.rank, third.background_count, third.foreground), (0, 2, 1, true));
    assert!((pixel.components()[1].weight - 0.05 / 1.04).abs() < 1e-6);
}

#[test]
fn the_background_before_a_stopped_object_is_kept_until_it_leaves() {
    let parameters = plain(3);
    let mut pixel = Pixel::unseen(3);
    let mut t = 0;
    let mut show = |pixel: &mut Pixel, level: f32| {
        t += 1;
        pixel.update([level; 3], t, &parameters)
    };
    for _ in 0..300 {
        show(&mut pixel, 60.0);
    }
    let road = pixel.components()[0];
    let absorbed = (1..500).find(|_| !show(&mut pixel, 200.0).foreground).expect("the car is absorbed");
    let kept = *pixel.components().iter().find(|component| component.mean[0] < 100.0).unwrap();
    assert_eq!((kept.mean, kept.variance), (road.mean, road.variance), "absorbed after {absorbed} frames");
    let back = (1..100).find(|_| !show(&mut pixel, 60.0).foreground).expect("the road is background again");
    assert!(back * 4 < absorbed, "{back} frames, {absorbed} for a new surface");
}

/// A pixel of a calm scene under the default settings, for a minute at 25 frames per second.
#[test]
fn lasting_foreground_is_held_and_flicker_is_absorbed() {
    let parameters = |hold: f32, learning: f32, restless_t: f32| {
        let settings = occluscope::settings::Settings::default();
        Parameters::new(&occluscope::settings::Settings {
            hold,
            restless_learning: learning,
            restless_t,
            ..settings
        })
    };
    // The number of foreground frames among the last `count`.
    let late = |parameters: Parameters, frames: u32, count: u32, other: fn(u32) -> bool| {
        let mut pixel = Pixel::unseen(parameters.k);
        let verdicts = (1..=frames).map(|t| {
            let level = if other(t) { 200.0 } else { 60.0 };
            pixel.update([level; 3], t, &parameters).foreground
        });
        verdicts.skip((frames - count) as usize).filter(|&foreground| foreground).count()
    };
    let stands: fn(u32) -> bool = |t| t > 500;
    assert_eq!(late(parameters(0.05, 1.0, 0.0), 2000, 1000, stands), 1000);
    assert_eq!(late(parameters(1.0, 1.0, 0.0), 2000, 1000, stands), 0, "absorbed without feedback");
    let sways: fn(u32) -> bool = |t| t % 9 < 2;
    assert_eq!(late(parameters(0.05, 4.0, 0.85), 400, 100, sways), 0);
    assert!(
        late(parameters(1.0, 1.0, 0.0), 400, 100, sways) > 15,
        "foreground in each wave without feedback"
    );
}

#[test]
fn two_alternating_surfaces_are_background_at_a_higher_t_only() {
    for (t, expected) in [(0.9, 0), (0.3, 100)] {
        let mut mixture = Mixture::new(Size::new(1, 1), Parameters { t, ..plain(4) });
        let mut foreground = 0;
        for number in 1..=600 {
            let mask: Mask = mixture.step(&grey(number, if number % 4 == 0 { 180 } else { 60 }));
            if number > 200 {
                foreground += mask.foreground_pixels();
            }
        }
        assert_eq!(foreground, expected, "at T {t}");
    }
}

#[test]
fn recurring_background_is_learned_before_the_first_frame_and_standing_people_are_not() {
    let noise = |t: u32| (t * 7 % 5) as u8;
    let lamp =
        |t: u32| if (t / 18).is_multiple_of(2) { [90 + noise(t); 3] } else { [220 - noise(t), 190, 120] };
    let walker = |t: u32| if (100..215).contains(&t) { [30, 40 + noise(t), 90] } else { [130 + noise(t); 3] };
    let parameters = Parameters { learnt: 300, ..Parameters::new(&Settings::default()) };
    let learn = |colour: &dyn Fn(u32) -> [u8; 3]| {
        let mut pixel = Pixel::unseen(parameters.k);
        for t in 1..=300 {
            pixel.update(parameters.value(colour(t)), t, &parameters);
        }
        pixel
    };
    let judge =
        |mut pixel: Pixel, rgb: [u8; 3]| pixel.update(parameters.value(rgb), 301, &parameters).foreground;
    let (flashes, stood) = (learn(&lamp), learn(&walker));
    assert_eq!([judge(flashes, lamp(0)), judge(flashes, lamp(18))], [false; 2]);
    assert!(judge(flashes, [30, 40, 90]), "a walker before the lamp");
    assert_eq!([judge(stood, walker(1)), judge(stood, walker(150))], [false, true]);
    let mut begun = flashes;
    begun.begin(&parameters);
    assert_eq!(begun.used(), 2);
    assert!((begun.components().iter().map(|it| it.weight).sum::<f32>() - 1.0).abs() < 1e-6);
}
