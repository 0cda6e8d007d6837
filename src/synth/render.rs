//! Renders a scene's frames and their ground truth.

use std::borrow::Cow;

use rayon::prelude::*;

use super::layer::Layer;
use super::path::Path;
use super::scene::{Actor, Scene};
use super::texture::{Colour, hash};
use super::{background, car, walker};
use crate::frame::{Frame, Size};
use crate::regions::Rect;
use crate::tracking::Identity;

/// Two people touch when at most this many pixels less one are between them: a detector's region bridges such a gap
/// because of their soft outlines.
pub const TOUCH_PIXELS: i32 = 2;

/// A person or a car in one frame: its size without occlusion, and its visible part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Silhouette {
    /// Its identity.
    pub id: Identity,
    /// The bounding box of the full silhouette, including occluded parts, clipped to the image.
    pub bbox: Rect,
    /// Number of pixels of the full silhouette, including those outside the image.
    pub full: u32,
    /// Number of its pixels inside the image.
    pub inside: u32,
    /// Number of those that no occluder of the scene hides; other people may hide them.
    pub unscreened: u32,
    /// Number of visible pixels.
    pub visible: u32,
    /// Whether it is a parked car, which belongs to the background until it moves. Standing people remain foreground.
    pub parked: bool,
}

impl Silhouette {
    /// Least visible share of the full silhouette.
    pub const LEAST: f32 = 0.05;

    /// Visible pixels / pixels of the full silhouette, as in MOTChallenge: 0..=1.
    pub fn visibility(&self) -> f32 {
        self.visible as f32 / self.full.max(1) as f32
    }

    /// Whether enough of it is inside the image.
    pub fn is_inside(&self) -> bool {
        self.inside as f32 >= Self::LEAST * self.full as f32 && self.inside > 0
    }

    /// Whether it is occluded by the scene: less than 5 % of its part inside the image is unscreened.
    pub fn is_hidden(&self) -> bool {
        (self.unscreened as f32) < Self::LEAST * self.inside as f32
    }
}

/// The ground truth of one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameTruth {
    /// The frame's number, from 1.
    pub number: u32,
    /// Width and height.
    pub size: Size,
    /// The identity visible at each pixel, row by row; 0 for background, parked cars and occluders.
    pub identities: Vec<u8>,
    /// All objects with at least one pixel inside the image, by identity.
    pub silhouettes: Vec<Silhouette>,
    /// Pairs of people, the lower identity first, whose unscreened silhouettes touch or overlap.
    pub touching: Vec<(Identity, Identity)>,
    /// The objects of `silhouettes`, the farthest first.
    pub depth: Vec<Identity>,
}

/// Renders the frames of a scene, each independently of the others.
#[derive(Clone, Debug)]
pub struct Renderer {
    scene: Scene,
    background: Vec<Colour>,
    occluders: Vec<Layer>,
}

/// An object to be composited on the background.
enum Thing<'a> {
    Mover(Identity, &'a Layer),
    Occluder(&'a Layer),
}

impl Renderer {
    /// Renders the static parts once.
    pub fn new(scene: &Scene) -> Self {
        let background = background::draw(scene.background, scene.size, scene.seed);
        let occluders = (1u64..)
            .zip(&scene.occluders)
            .map(|(number, occluder)| occluder.draw(scene.size, scene.seed.wrapping_add(number << 20)))
            .collect();
        Self { scene: scene.clone(), background, occluders }
    }

    /// Renders frame `number`, from 1; numbers beyond the scene's frames continue the motion.
    pub fn frame(&self, number: u32) -> (Frame, FrameTruth) {
        let size = self.scene.size;
        let shake = self.shake(number);
        let (movers, occluders) = (self.movers(number, shake), self.occluders(number, shake));
        let things = self.by_depth(&movers, &occluders, number);

        let mut light = self.place(number, shake);
        if self.scene.shadows {
            let people = movers.iter().filter(|(id, _)| *id as usize <= self.scene.actors.len());
            for (_, layer) in people {
                cast_shadow(&mut light, size, layer);
            }
        }
        let mut identities = vec![0; size.pixels()];
        for (_, thing) in &things {
            let (identity, layer) = match thing {
                Thing::Mover(identity, layer) => (*identity as u8, *layer),
                Thing::Occluder(layer) => (0, *layer),
            };
            lay(&mut light, &mut identities, size, layer, identity);
        }
        self.scene.light.fall_on(&mut light, size, number as f32);

        let row_bytes = size.width as usize * 3;
        let mut rgb = vec![0; size.pixels() * 3];
        rgb.par_chunks_mut(row_bytes).zip(light.par_chunks(size.width as usize)).enumerate().for_each(
            |(row, (bytes, light))| {
                self.scene.noise.expose(light, bytes, self.scene.seed, number, row as u32);
            },
        );

        let parked: Vec<Identity> = self.parked(number).collect();
        let truth = truth_of(number, size, identities, &things, &parked);
        let time = f64::from(number - 1) / f64::from(self.scene.fps);
        (Frame::new(number, size, rgb).at_time(time), truth)
    }

    /// The camera's displacement in a frame, in pixels to the right and down.
    fn shake(&self, number: u32) -> [i32; 2] {
        let reach = u64::from(self.scene.jitter);
        [0x78, 0x79].map(|axis| {
            let chance = hash(self.scene.seed ^ 0x6A69_7474, i64::from(number), axis);
            (chance % (2 * reach + 1)) as i32 - reach as i32
        })
    }

    /// The background without people.
    fn place(&self, number: u32, [x, y]: [i32; 2]) -> Vec<Colour> {
        let Size { width, height } = self.scene.size;
        let mut light = self.background.clone();
        for (motion, seed) in self.scene.motions.iter().zip(1u64..) {
            motion.draw(&mut light, self.scene.size, self.scene.seed.wrapping_add(seed << 30), number as f32);
        }
        if [x, y] == [0, 0] {
            return light;
        }
        let from = |to: u32, shift: i32, end: u32| (to as i32 - shift).clamp(0, end as i32 - 1) as usize;
        let rows = (0..height).map(|row| from(row, y, height) * width as usize);
        rows.flat_map(|row| (0..width).map(move |column| row + from(column, x, width)))
            .map(|at| light[at])
            .collect()
    }

    /// The path of an identity.
    fn path(&self, id: Identity) -> &Path {
        let index = id as usize - 1;
        let people = self.scene.actors.len();
        if index < people { &self.scene.actors[index].path } else { &self.scene.cars[index - people].path }
    }

    /// The identities of the parked cars.
    fn parked(&self, number: u32) -> impl Iterator<Item = Identity> {
        let first = self.scene.actors.len() as Identity + 1;
        let cars = (first..).zip(&self.scene.cars);
        cars.filter(move |(_, car)| car.path.stands(number as f32)).map(|(id, _)| id)
    }

    /// All people and cars that reach into the image.
    fn movers(&self, number: u32, shake: [i32; 2]) -> Vec<(Identity, Layer)> {
        let (width, height) = (self.scene.size.width as i32, self.scene.size.height as i32);
        // No part of a person is farther from the path than their height.
        let near = |actor: &Actor| {
            let ([x, _], reach) = (actor.path.position(number as f32), actor.height_at(number as f32) + 9.0);
            x + reach > 0.0 && x - reach < width as f32
        };
        let people = (1..).zip(&self.scene.actors).filter(|(_, actor)| near(actor)).map(|(id, actor)| {
            let seed = self.scene.seed.wrapping_add(u64::from(id) << 40);
            (id, walker::draw(actor, number as f32, seed))
        });
        let first_car = self.scene.actors.len() as Identity + 1;
        let cars = (first_car..).zip(&self.scene.cars).map(|(id, car)| (id, car::draw(car, number as f32)));
        people
            .chain(cars)
            .map(|(id, layer)| (id, layer.moved(shake)))
            .filter(|(_, layer)| {
                layer.x < width
                    && layer.y < height
                    && layer.x + layer.width as i32 > 0
                    && layer.y + layer.height as i32 > 0
            })
            .collect()
    }

    /// The occluders in a frame.
    fn occluders(&self, number: u32, shake: [i32; 2]) -> Vec<Cow<'_, Layer>> {
        let occluders = self.scene.occluders.iter().zip(&self.occluders);
        occluders
            .map(|(occluder, layer)| {
                let swayed = occluder.swayed(layer, number as f32).map_or(Cow::Borrowed(layer), Cow::Owned);
                if shake == [0, 0] { swayed } else { Cow::Owned(swayed.into_owned().moved(shake)) }
            })
            .collect()
    }

    /// All objects with the row of their foot, the farthest first.
    fn by_depth<'a>(
        &self,
        movers: &'a [(Identity, Layer)],
        occluders: &'a [Cow<Layer>],
        number: u32,
    ) -> Vec<(f32, Thing<'a>)> {
        let mover = |(id, layer): &'a (Identity, Layer)| {
            (self.path(*id).position(number as f32)[1], Thing::Mover(*id, layer))
        };
        let occluders = self.scene.occluders.iter().zip(occluders);
        let mut things: Vec<_> = movers
            .iter()
            .map(mover)
            .chain(occluders.map(|(occluder, layer)| (occluder.at[1], Thing::Occluder(layer))))
            .collect();
        things.sort_by(|a, b| a.0.total_cmp(&b.0));
        things
    }
}

/// All frames of a scene in order.
pub fn render(scene: &Scene) -> impl Iterator<Item = (Frame, FrameTruth)> + use<> {
    let renderer = Renderer::new(scene);
    (1..=scene.frames).map(move |number| renderer.frame(number))
}

/// Composites a layer on the image and records the identity of its solid pixels.
fn lay(light: &mut [Colour], identities: &mut [u8], size: Size, layer: &Layer, identity: u8) {
    for (at, x, y) in layer.places() {
        let coverage = layer.coverage[at];
        let Some(place) = place(size, x, y).filter(|_| coverage > 0.0) else { continue };
        for (under, over) in light[place].iter_mut().zip(layer.colour[at]) {
            *under = *under * (1.0 - coverage) + over;
        }
        if coverage >= Layer::SOLID {
            identities[place] = identity;
        }
    }
}

/// Renders a soft contact shadow below a person's feet.
fn cast_shadow(light: &mut [Colour], size: Size, layer: &Layer) {
    let (half_width, half_height) = (layer.width as f32 * 0.62, layer.height as f32 * 0.055);
    let middle = [layer.x as f32 + layer.width as f32 * 0.56, (layer.y + layer.height as i32) as f32 - 2.0];
    let (left, right) = ((middle[0] - half_width) as i32, (middle[0] + half_width) as i32);
    let (top, bottom) = ((middle[1] - half_height) as i32, (middle[1] + half_height) as i32);
    for (x, y) in (top..=bottom).flat_map(|y| (left..=right).map(move |x| (x, y))) {
        let away = ((x as f32 - middle[0]) / half_width).hypot((y as f32 - middle[1]) / half_height);
        if let Some(at) = place(size, x, y) {
            let dark = 1.0 - 0.45 * (1.0 - away).max(0.0).powf(0.7);
            light[at] = light[at].map(|channel| channel * dark);
        }
    }
}

fn place(size: Size, x: i32, y: i32) -> Option<usize> {
    size.index(u32::try_from(x).ok()?, u32::try_from(y).ok()?)
}

fn truth_of(
    number: u32,
    size: Size,
    mut identities: Vec<u8>,
    things: &[(f32, Thing)],
    parked: &[Identity],
) -> FrameTruth {
    let mut seen = [0u32; 256];
    for &identity in &identities {
        seen[identity as usize] += 1;
    }
    let mut silhouettes = Vec::new();
    let mut depth = Vec::new();
    let mut unscreened_masks = Vec::new();
    for (place, (_, thing)) in things.iter().enumerate() {
        let Thing::Mover(id, layer) = thing else { continue };
        let screens: Vec<&Layer> = things[place + 1..]
            .iter()
            .filter_map(|(_, nearer)| if let Thing::Occluder(layer) = nearer { Some(*layer) } else { None })
            .collect();
        let (mut full, mut inside, mut unscreened) = (0, 0, 0);
        let (mut least, mut most) = ([i32::MAX; 2], [i32::MIN; 2]);
        let mut mask = vec![false; layer.coverage.len()];
        for (at, x, y) in layer.places().filter(|&(at, ..)| layer.coverage[at] >= Layer::SOLID) {
            full += 1;
            if self::place(size, x, y).is_none() {
                continue;
            }
            inside += 1;
            least = [least[0].min(x), least[1].min(y)];
            most = [most[0].max(x), most[1].max(y)];
            mask[at] = !screens.iter().any(|screen| screen.is_solid(x, y));
            unscreened += u32::from(mask[at]);
        }
        if inside == 0 {
            continue;
        }
        let [w, h] = [most[0] - least[0] + 1, most[1] - least[1] + 1];
        let bbox = Rect::new(least[0] as f32, least[1] as f32, w as f32, h as f32);
        let visible = seen[*id as usize & 255];
        let parked = parked.contains(id);
        silhouettes.push(Silhouette { id: *id, bbox, full, inside, unscreened, visible, parked });
        depth.push(*id);
        if !parked {
            unscreened_masks.push((*id, *layer, mask));
        }
    }
    for identity in &mut identities {
        if parked.contains(&Identity::from(*identity)) {
            *identity = 0;
        }
    }
    silhouettes.sort_by_key(|silhouette| silhouette.id);
    unscreened_masks.sort_by_key(|(id, ..)| *id);
    let mut touching = Vec::new();
    for (place, (id, layer, mask)) in unscreened_masks.iter().enumerate() {
        for (other_id, other_layer, other_mask) in &unscreened_masks[place + 1..] {
            if touch(layer, mask, other_layer, other_mask) {
                touching.push((*id, *other_id));
            }
        }
    }
    FrameTruth { number, size, identities, silhouettes, touching, depth }
}

/// Whether two silhouettes come within [`TOUCH_PIXELS`] of each other.
fn touch(a: &Layer, a_mask: &[bool], b: &Layer, b_mask: &[bool]) -> bool {
    let near = -TOUCH_PIXELS..=TOUCH_PIXELS;
    a.places().filter(|&(at, ..)| a_mask[at]).any(|(_, x, y)| {
        let (column, row) = (x - b.x, y - b.y);
        let reach = TOUCH_PIXELS;
        if column < -reach
            || row < -reach
            || column >= b.width as i32 + reach
            || row >= b.height as i32 + reach
        {
            return false;
        }
        near.clone().any(|dy| {
            near.clone().any(|dx| {
                let (column, row) = (column + dx, row + dy);
                (0..b.width as i32).contains(&column)
                    && (0..b.height as i32).contains(&row)
                    && b_mask[row as usize * b.width + column as usize]
            })
        })
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

    use super::*;
    use crate::regions::colour::delta_e;
    use crate::synth::{SceneParameters, catalogue};

    fn scene(name: &str, seed: u64) -> Scene {
        let parameters =
            SceneParameters { size: Size::new(128, 96), seed, shadows: true, ..SceneParameters::default() };
        catalogue::scene(name, &parameters).unwrap()
    }

    #[test]
    fn a_seed_gives_the_same_bits_on_any_threads_and_in_any_order() {
        for entry in catalogue::entries() {
            let scene = scene(entry.name, 5);
            let numbers = [40, 90, 120];
            let first = Renderer::new(&scene);
            let one: Vec<_> = numbers.iter().map(|&number| first.frame(number)).collect();
            let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
            let second = alone.install(|| Renderer::new(&scene));
            for (place, &number) in numbers.iter().enumerate().rev() {
                let again = alone.install(|| second.frame(number));
                assert!(again == one[place], "{} frame {number}", entry.name);
            }
        }
    }

    #[test]
    fn frames_differ_between_seeds_and_numbers() {
        let (one, other) = (Renderer::new(&scene("empty", 1)), Renderer::new(&scene("empty", 2)));
        assert_ne!(one.frame(1).0.rgb, other.frame(1).0.rgb);
        assert_ne!(one.frame(1).0.rgb, one.frame(2).0.rgb, "noise differs");
    }

    #[test]
    fn truth_agrees_with_the_pixels() {
        for (name, seed) in [("crossing", 1), ("tree", 2), ("group", 3), ("pole", 4), ("wall", 5)] {
            let scene = scene(name, seed);
            for (_, truth) in render(&scene).step_by(3) {
                for who in &truth.silhouettes {
                    let mut seen = 0;
                    for (at, &identity) in truth.identities.iter().enumerate() {
                        if u32::from(identity) != who.id {
                            continue;
                        }
                        seen += 1;
                        let (x, y) = ((at % 128) as f32, (at / 128) as f32);
                        let inside = x >= who.bbox.x
                            && y >= who.bbox.y
                            && x < who.bbox.right()
                            && y < who.bbox.bottom();
                        assert!(inside, "{name} frame {}", truth.number);
                    }
                    assert_eq!(seen, who.visible);
                    assert!(who.visible <= who.unscreened && who.unscreened <= who.inside);
                    assert!(who.inside <= who.full && who.inside as f32 <= who.bbox.area());
                }
                let known = |&id: &u8| id == 0 || truth.silhouettes.iter().any(|who| who.id == u32::from(id));
                assert!(truth.identities.iter().all(known));
            }
        }
    }

    #[test]
    fn a_single_person_is_fully_visible_and_of_constant_size() {
        let scene = scene("crossing", 1);
        let walker = &scene.actors[0];
        let height = walker.height;
        let lone = Scene { actors: vec![walker.clone()], ..scene };
        let mut whole = 0;
        for (_, truth) in render(&lone) {
            for who in truth.silhouettes.iter().filter(|who| who.full == who.inside) {
                assert_eq!(who.visible, who.full);
                assert!((who.bbox.h - height).abs() < 0.08 * height, "{} of {height}", who.bbox.h);
                let share = who.full as f32 / (height * height);
                assert!((0.09..0.20).contains(&share), "{share}");
                whole += 1;
            }
        }
        assert!(whole > 40, "{whole}");
    }

    #[test]
    fn people_have_contrast_with_each_other_and_the_background() {
        for seed in 1..=6 {
            for name in ["crossing", "tree", "overtake", "wall", "pole"] {
                let scene = scene(name, seed);
                let bare = Scene { actors: Vec::new(), ..scene.clone() };
                let empty = Renderer::new(&bare).frame(1).0;
                let number = scene.actors[0].path.frame as u32 - 25;
                let (frame, truth) = Renderer::new(&scene).frame(number);
                let own = (0..frame.size.pixels()).filter(|&at| truth.identities[at] != 0);
                let (mut plain, mut all) = (0, 0);
                for at in own {
                    let colour = |rgb: &[u8]| [rgb[3 * at], rgb[3 * at + 1], rgb[3 * at + 2]];
                    plain += u32::from(delta_e(colour(&frame.rgb), colour(&empty.rgb)) > 15.0);
                    all += 1;
                }
                assert!(all > 50 && plain * 100 > all * 80, "{name} {seed}: {plain} of {all}");
            }
            let [one, other] = &scene("crossing", seed).actors[..] else { panic!("two") };
            assert!(delta_e(one.clothes.shirt, other.clothes.shirt) > 40.0, "seed {seed}");
            let [one, other] = &scene("crossing-alike", seed).actors[..] else { panic!("two") };
            assert!(delta_e(one.clothes.shirt, other.clothes.shirt) < 10.0, "seed {seed}");
        }
    }
}
