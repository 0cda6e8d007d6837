//! Export of plots and tables.

use super::*;

#[test]
fn a_zoomed_history_exports_its_visible_frames() {
    let (mut harness, actions) = tall(Some(shown(430)));
    open(&mut harness, "History");
    harness.get_by_label("+").click();
    harness.run();
    choose(&mut harness, "Copy or save the frames in view", "Save CSV…");
    // 300 frames from 215.25.
    let [InspectorAction::Save(Table::History(_, frames))] = &actions.take()[..] else { panic!("no table") };
    assert_eq!(*frames, 215..516);
    choose(&mut harness, "Copy or save the frames in view", "Save SVG…");
    let [InspectorAction::SavePicture(plot, Format::Svg)] = &actions.take()[..] else { panic!("no figure") };
    assert_eq!(plot.figure().title, "pixel (5, 4), frames 216–516");
}

#[test]
fn a_map_is_saved_cell_by_cell() {
    let shown = shown(430);
    let tuning = tuning_of(&shown, [TunableSetting::Alpha, TunableSetting::T]).unwrap();
    let (mut harness, actions) = tall(Some(shown));
    open(&mut harness, "Tuning");
    choose(&mut harness, "Copy or save the map", "Save CSV…");
    let [InspectorAction::Save(table)] = &actions.take()[..] else { panic!("one table is requested") };
    assert_eq!(table.name(), "tuning-5-4.csv");
    let folder = tempfile::tempdir().unwrap();
    let path = table.save(folder.path().join("map")).unwrap();
    let text = std::fs::read_to_string(path).unwrap();
    let lines: Vec<_> = text.lines().collect();
    assert_eq!((lines.len(), lines[0]), (1 + 24 * 24, "alpha,t,foreground"));
    for (column, row) in [(0, 0), (23, 0), (5, 17), (23, 23)] {
        let [x, y] = &tuning.map.axes;
        let foreground = u8::from(tuning.map.is_foreground(column, row));
        let line = format!("{},{},{foreground}", x.values[column], y.values[row]);
        assert_eq!(lines[1 + row * 24 + column], line);
    }
    let nowhere = folder.path().join("none").join("map.csv");
    assert!(
        table.save(nowhere).unwrap_err().contains("map.csv cannot be written: its folder does not exist")
    );
}

#[test]
fn every_plot_is_exported_as_an_image_a_drawing_a_page_and_a_table() {
    let shown = shown(430);
    let history = Arc::clone(shown.pixel.as_ref().unwrap());
    let (mut harness, actions) = tall(Some(shown));
    let folder = tempfile::tempdir().unwrap();
    for (tab, menu, file, frames) in [
        ("Mixture", "Copy or save the densities", "densities-5-4", 430..431),
        ("Mixture", "Copy or save the weights", "weights-5-4", 430..431),
        ("History", "Copy or save the frames in view", "history-5-4", 0..600),
        ("Scatter", "Copy or save the scatter plot", "scatter-5-4", 0..431),
        ("3-D", "Copy or save the scatter plot", "scatter-3d-5-4", 0..431),
        ("Tuning", "Copy or save the map", "tuning-5-4", 0..0),
    ] {
        open(&mut harness, tab);
        harness.get_by_label(menu).click();
        harness.run();
        picture(&mut harness, &format!("menu-{}", tab.to_lowercase()));
        harness.get_by_label("Copy image").click();
        harness.run();
        let [InspectorAction::CopyPicture(plot)] = &actions.take()[..] else { panic!("{tab}: no picture") };
        let picture = plot.drawn().unwrap();
        assert!(picture.size.width > 900 && picture.rgb[..3] == [255; 3], "{tab}: white background");
        for (entry, format, begins) in [
            ("Save PNG…", Format::Png, &b"\x89PNG"[..]),
            ("Save SVG…", Format::Svg, b"<svg"),
            ("Save PDF…", Format::Pdf, b"%PDF-"),
        ] {
            choose(&mut harness, menu, entry);
            let [InspectorAction::SavePicture(same, asked)] = &actions.take()[..] else {
                panic!("{tab}: no file")
            };
            assert_eq!((same, *asked), (plot, format));
            assert_eq!(same.name(format), format!("{file}.{}", format.ending()));
            let path = same.save(folder.path().join(same.name(format)), format).unwrap();
            assert!(std::fs::read(path).unwrap().starts_with(begins), "{tab}");
        }
        choose(&mut harness, menu, "Copy CSV");
        let [InspectorAction::Copy(table)] = &actions.take()[..] else { panic!("{tab}: no table") };
        match table {
            Table::History(of, range) => {
                assert!(Arc::ptr_eq(of, &history) && *range == frames, "{tab} {range:?}");
            }
            other => assert_eq!(other.name(), "tuning-5-4.csv"),
        }
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 18, "no other files are written");
}

#[test]
fn a_scatter_plot_exports_its_displayed_frames() {
    let (mut harness, actions) = tall(Some(shown(430)));
    open(&mut harness, "Scatter");
    for (choice, expected) in [("100", 331..431), ("all", 0..600)] {
        open(&mut harness, choice);
        choose(&mut harness, "Copy or save the scatter plot", "Copy CSV");
        let [InspectorAction::Copy(Table::History(_, frames))] = &actions.take()[..] else {
            panic!("no table")
        };
        assert_eq!(*frames, expected);
    }
}

#[test]
fn the_region_and_the_pins_are_exported_as_an_image_a_drawing_a_page_and_a_table() {
    let shown = shown(430);
    let history = Arc::clone(shown.pixel.as_ref().unwrap());
    let other = Arc::new(PixelHistory { at: (1, 2), ..history_of(&settings(), 600) });
    let histories = [Arc::clone(&other), Arc::clone(&history)];
    let (model, cleaned) = (vec![0.5; 600], vec![0.25; 600]);
    let region = Arc::new(RegionShares { at: AT, side: 5, pixels: 25, model, cleaned });
    let actions = Rc::new(RefCell::new(Vec::new()));
    let (asked, mut inspector, shares) = (Rc::clone(&actions), Inspector::default(), Arc::clone(&region));
    let mut harness = Harness::builder()
        .with_size(Vec2::new(380.0, 900.0))
        .with_context_setup(crate::app::theme::install)
        .wgpu()
        .build_ui(move |ui| {
            let context = InspectorContext {
                chosen: Some(AT),
                pins: &[(2, AT), (5, (1, 2)), (6, (3, 3))],
                histories: &histories,
                shares: Some(&shares),
                ..InspectorContext::default()
            };
            egui::CentralPanel::default().show(ui, |ui| {
                asked.borrow_mut().extend(inspector.ui(
                    ui,
                    Some(&shown),
                    None,
                    None,
                    FrameTimes { fps: 10.0, times: &[] },
                    &context,
                ));
            });
        });
    open(&mut harness, "Pixels");
    picture(&mut harness, "pixels");
    looks_as_before(&harness.render().unwrap(), None, "pixels");
    let folder = tempfile::tempdir().unwrap();
    for (menu, file, rows) in [
        ("Copy or save the foreground ratio", "region-5-4", 600),
        ("Copy or save the pinned pixels", "pins", 1200),
    ] {
        choose(&mut harness, menu, "Copy image");
        let [InspectorAction::CopyPicture(plot)] = &actions.take()[..] else { panic!("{file}: no picture") };
        let picture = plot.drawn().unwrap();
        assert!(picture.size.width > 2000 && picture.rgb[..3] == [255; 3], "{file}: page width on white");
        for (entry, format) in
            [("Save PNG…", Format::Png), ("Save SVG…", Format::Svg), ("Save PDF…", Format::Pdf)]
        {
            choose(&mut harness, menu, entry);
            let [InspectorAction::SavePicture(same, asked)] = &actions.take()[..] else { panic!("no file") };
            assert_eq!(
                (same, *asked, same.name(format)),
                (plot, format, format!("{file}.{}", format.ending()))
            );
            same.save(folder.path().join(same.name(format)), format).unwrap();
        }
        choose(&mut harness, menu, "Save CSV…");
        let [InspectorAction::Save(table)] = &actions.take()[..] else { panic!("{file}: no table") };
        assert_eq!((table.name(), table.rows()), (format!("{file}.csv"), rows));
        assert_eq!(table.csv().unwrap().lines().count(), rows + 1);
    }
    // The history of an unavailable pin cannot be exported.
    choose(&mut harness, "Copy or save the pinned pixels", "Copy CSV");
    let [InspectorAction::Copy(Table::Pins(pins))] = &actions.take()[..] else { panic!("no table") };
    assert_eq!(pins.iter().map(|(number, of)| (*number, of.at)).collect::<Vec<_>>(), [(2, AT), (5, (1, 2))]);
}
