//! The time of each stage per frame, and how it scales: `cargo bench --bench stages`.
//!
//! A rendered scene of walkers, scaled to common sizes of video.

#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

use std::hint::black_box;

use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use occluscope::frame::{Frame, Mask, Size};
use occluscope::mixture::{BATCH, Mixture, Parameters};
use occluscope::occlusion::Tracker;
use occluscope::pipeline::Pipeline;
use occluscope::regions::{Cleaning, Region, find_regions};
use occluscope::settings::{Rate, Settings};
use occluscope::source;

const SIZES: [Size; 3] = [Size::new(768, 576), Size::new(1920, 1080), Size::new(3840, 2160)];

/// The first frames of a bundled sample at another size; enough for the models to settle.
fn frames(size: Size, count: usize) -> Vec<Frame> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/sample_videos/crossing.mp4");
    let mut source = source::open(path, source::Options::default()).expect("the bundled sample");
    let small: Vec<_> = std::iter::from_fn(|| source.next_frame().unwrap()).take(count).collect();
    let enlarge = |frame: &Frame| {
        let mut rgb = Vec::with_capacity(size.pixels() * 3);
        for y in 0..size.height {
            for x in 0..size.width {
                let (x, y) = (x * frame.size.width / size.width, y * frame.size.height / size.height);
                rgb.extend(frame.pixel(x, y).unwrap());
            }
        }
        Frame::new(frame.number, size, rgb)
    };
    small.iter().map(enlarge).collect()
}

fn settings() -> Settings {
    Settings::default()
}

fn mixture(c: &mut Criterion) {
    let mut group = c.benchmark_group("mixture");
    group.sample_size(20);
    for size in SIZES {
        let all = frames(size, 2 * BATCH);
        let (before, batch) = all.split_at(BATCH);
        let (before, batch): (Vec<_>, Vec<_>) = (before.iter().collect(), batch.iter().collect());
        let mut masks = vec![Mask::empty(size); BATCH];
        group.throughput(Throughput::Elements((size.pixels() * BATCH) as u64));
        for k in [1, 3, 5, 8] {
            for rate in [Rate::Weight, Rate::Density] {
                if rate == Rate::Density && k != 3 {
                    continue;
                }
                let parameters = Parameters::new(&Settings { k, rate, ..settings() });
                let mut model = Mixture::new(size, parameters);
                model.step_many(&before, &mut masks);
                let name = format!("K={k} {} {size}", rate.word());
                group.bench_function(BenchmarkId::new("stream", &name), |b| {
                    b.iter(|| batch.iter().for_each(|frame| drop(black_box(model.step(frame)))));
                });
                group.bench_function(BenchmarkId::new("replay", &name), |b| {
                    b.iter(|| model.step_many(black_box(&batch), &mut masks));
                });
            }
        }
        let mut model = Mixture::new(size, Parameters::new(&settings()));
        model.step_many(&before, &mut masks);
        group.throughput(Throughput::Elements(size.pixels() as u64));
        group.bench_function(BenchmarkId::new("appearance", size), |b| {
            b.iter(|| black_box(model.background_images()));
        });
        group.bench_function(BenchmarkId::new("copy", size), |b| b.iter(|| black_box(model.clone())));
    }
    group.finish();
}

/// A mask with this many squares of foreground on a grid, and occasional specks.
fn squares(size: Size, count: u32) -> Mask {
    let mut mask = Mask::empty(size);
    let columns = (f64::from(count).sqrt().ceil() as u32).max(1);
    let cell = (size.width / columns, size.height / columns);
    for square in 0..count {
        let (left, top) = (square % columns * cell.0, square / columns * cell.1);
        for y in top..top + cell.1 / 2 {
            for x in left..left + cell.0 / 2 {
                mask.data[size.index(x, y).unwrap()] = Mask::FOREGROUND;
            }
        }
    }
    (0..size.pixels()).step_by(997).for_each(|at| mask.data[at] = Mask::FOREGROUND);
    mask
}

fn regions(c: &mut Criterion) {
    let mut group = c.benchmark_group("regions");
    for size in SIZES {
        let frame = frames(size, 1).remove(0);
        group.throughput(Throughput::Elements(size.pixels() as u64));
        let cleaning = Cleaning::new(&settings());
        for count in [10, 300] {
            let mask = squares(size, count);
            let name = format!("{count} regions {size}");
            group.bench_function(BenchmarkId::new("clean", &name), |b| {
                b.iter_batched(|| mask.clone(), |mask| cleaning.apply(mask).unwrap(), BatchSize::LargeInput);
            });
            group.bench_function(BenchmarkId::new("find", &name), |b| {
                b.iter(|| black_box(find_regions(&frame, &mask, 20)));
            });
        }
    }
    group.finish();
}

/// Regions that drift with small variations between frames.
fn drifting(size: Size, count: u32) -> Vec<Vec<Region>> {
    let frame = frames(size, 1).remove(0);
    (0..40_usize)
        .map(|shift| {
            let mut mask = squares(size, count);
            mask.data.rotate_right(3 * shift);
            find_regions(&frame, &mask, 20).1
        })
        .collect()
}

fn tracking(c: &mut Criterion) {
    let size = SIZES[0];
    let mut group = c.benchmark_group("tracking and occlusion");
    group.sample_size(20);
    for count in [3, 10, 30, 100, 300] {
        let sequence = drifting(size, count);
        for hypotheses in [20, 200] {
            let settings = Settings { max_hypotheses: hypotheses, ..settings() };
            group.throughput(Throughput::Elements(sequence.len() as u64));
            let name = format!("{count} regions, {hypotheses} hypotheses");
            group.bench_function(BenchmarkId::new("frames", name), |b| {
                b.iter(|| {
                    let mut tracker = Tracker::new(&settings, size, 25.0);
                    for (number, regions) in (1..).zip(&sequence) {
                        black_box(tracker.step(number, f64::from(number) / 25.0, regions));
                    }
                });
            });
        }
    }
    group.finish();
}

fn pipeline(c: &mut Criterion) {
    let mut group = c.benchmark_group("pipeline");
    group.sample_size(20);
    for size in SIZES {
        let all = frames(size, 3 * BATCH);
        let batches: Vec<Vec<_>> = all.chunks(BATCH).map(|batch| batch.iter().collect()).collect();
        group.throughput(Throughput::Elements(all.len() as u64));
        group.bench_function(BenchmarkId::new("frames", size), |b| {
            b.iter(|| {
                let mut pipeline = Pipeline::new(&settings(), size, 25.0).unwrap();
                for batch in &batches {
                    black_box(pipeline.step_many(batch).unwrap());
                }
            });
        });
    }
    group.finish();
}

criterion_group!(benches, mixture, regions, tracking, pipeline);
criterion_main!(benches);
