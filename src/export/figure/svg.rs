//! Writes a figure as SVG.
//!
//! Text is written as text, so that it can be edited and searched. Each panel is a group with its left, top, width
//! and height as `data-place` and the ends of its axes as `data-x` and `data-y` (`data-log` names the logarithmic
//! ones), and each mark has its name as `data-name`, so that values can be read back.

use svg::node::element::{
    Circle, ClipPath, Definitions, Description, Group, Line, Path, Polygon, Polyline, Rectangle, Text, Title,
};
use svg::{Document, Node};

use super::text::{FAMILY, LEGEND, LINE, MARGIN, SIGN};
use super::{Anchor, DrawnAxes, Figure, GRAY, INK, Key, Mark, MarkShape, Panel, SMALL, Sign, TEXT};
use crate::regions::Rgb;

/// Distance from a panel's left edge to the middle of its axis' name.
const NAME: f64 = 30.0;

/// The SVG text of the figure.
pub fn write(figure: &Figure) -> String {
    let [width, height] = figure.size;
    let mut clips = Definitions::new();
    for (at, panel) in figure.panels.iter().enumerate() {
        // A line along an edge keeps its whole width.
        let [left, top, width, height] = panel.place;
        let inside = rectangle([left - 0.5, top - 0.5, width + 1.0, height + 1.0]);
        clips.append(ClipPath::new().set("id", format!("panel{at}")).add(inside));
    }
    let mut document = Document::new()
        .set("width", format!("{}pt", short(width)))
        .set("height", format!("{}pt", short(height)))
        .set("viewBox", format!("0 0 {} {}", short(width), short(height)))
        .set("font-family", FAMILY)
        .add(Title::new(figure.title.as_str()))
        .add(Description::new().add(svg::node::Text::new(figure.description.as_str())))
        .add(clips)
        .add(rectangle([0.0, 0.0, width, height]).set("fill", "#ffffff"))
        .add(text_element([MARGIN, 14.0], &figure.title, Anchor::Start, TEXT, INK));
    for (key, (x, line)) in figure.legend.iter().zip(figure.legend_places()) {
        let y = LEGEND + (line as f64 + 0.5) * LINE;
        document = document.add(sign(key, [x + 6.5, y])).add(text_element(
            [x + SIGN, y + 0.36 * SMALL],
            &key.name,
            Anchor::Start,
            SMALL,
            INK,
        ));
    }
    for (at, panel) in figure.panels.iter().enumerate() {
        document = document.add(panel_group(panel, at));
    }
    let mut text = document.to_string();
    text.push('\n');
    text
}

fn panel_group(panel: &Panel, at: usize) -> Group {
    let ends = |(from, to): (f64, f64)| format!("{from} {to}");
    let place = panel.place.map(short).join(" ");
    let mut group = Group::new()
        .set("data-place", place)
        .set("data-x", ends(panel.x.ends))
        .set("data-y", ends(panel.y.ends))
        .add(axes_below(panel));
    let logarithmic = [("x", &panel.x), ("y", &panel.y)].into_iter().filter(|(_, axis)| axis.logarithmic);
    let logarithmic: String = logarithmic.map(|(name, _)| name).collect();
    if !logarithmic.is_empty() {
        group = group.set("data-log", logarithmic);
    }
    let mut marks = Group::new().set("clip-path", format!("url(#panel{at})"));
    for mark in &panel.marks {
        if !matches!(mark.shape, MarkShape::Text { .. }) {
            marks = marks.add(drawn(panel, mark));
        }
    }
    group = group.add(marks).add(axes_above(panel));
    // Text may extend beyond the panel.
    for mark in &panel.marks {
        if let MarkShape::Text { at, text, anchor } = &mark.shape {
            // A white outline keeps text legible over lines.
            let element = text_element(panel.at(*at), text, *anchor, SMALL, mark.colour)
                .set("paint-order", "stroke")
                .set("stroke", "#ffffff")
                .set("stroke-width", "2")
                .set("stroke-linejoin", "round");
            group = group.add(element);
        }
    }
    group
}

fn drawn(panel: &Panel, mark: &Mark) -> Group {
    let group = Group::new();
    let group = if mark.name.is_empty() { group } else { group.set("data-name", mark.name.as_str()) };
    let group = if mark.opacity < 1.0 { group.set("opacity", short(mark.opacity)) } else { group };
    let colour = hex(mark.colour);
    match &mark.shape {
        MarkShape::Line { points, width, dashed } => {
            let line = Polyline::new()
                .set("points", points_text(panel, points))
                .set("fill", "none")
                .set("stroke", colour)
                .set("stroke-width", short(*width))
                .set("stroke-linejoin", "round");
            group.add(if *dashed { line.set("stroke-dasharray", "3 2") } else { line })
        }
        MarkShape::Area(points) => {
            group.add(Polygon::new().set("points", points_text(panel, points)).set("fill", colour))
        }
        MarkShape::Rects(rects) => {
            // One path for all cells, which is compact and has no seams.
            let cells = rects.iter().map(|&[x0, y0, x1, y1]| {
                let ([left, bottom], [right, top]) = (panel.at([x0, y0]), panel.at([x1, y1]));
                let [left, bottom, right, top] = [left, bottom, right, top].map(short);
                format!("M{left} {bottom}H{right}V{top}H{left}Z")
            });
            let path = cells.collect::<Vec<_>>().concat();
            group.add(Path::new().set("d", path).set("fill", colour).set("shape-rendering", "crispEdges"))
        }
        MarkShape::Dots { places, radius, sign } => {
            let places = places.iter().map(|place| panel.at(*place));
            places.fold(group, |group, place| group.add(dot(place, *radius, *sign, &colour)))
        }
        MarkShape::Text { .. } => group,
    }
}

fn dot([x, y]: [f64; 2], radius: f64, sign: Sign, colour: &str) -> Box<dyn Node> {
    let circle = Circle::new().set("cx", short(x)).set("cy", short(y)).set("r", short(radius));
    match sign {
        Sign::Ring => circle.set("fill", "none").set("stroke", colour).set("stroke-width", "0.7").into(),
        Sign::Cross => {
            let (left, top, length) = (short(x - radius), short(y - radius), short(2.0 * radius));
            let path = format!("M{left} {}h{length}M{} {top}v{length}", short(y), short(x));
            Path::new()
                .set("d", path)
                .set("fill", "none")
                .set("stroke", colour)
                .set("stroke-width", "1.2")
                .into()
        }
        _ => circle.set("fill", colour).into(),
    }
}

/// The grid lines, which are below the data.
fn axes_below(panel: &Panel) -> Group {
    let [left, top, width, height] = panel.place;
    let mut group = Group::new();
    if panel.frame == DrawnAxes::None || !panel.grid {
        return group;
    }
    for (value, _) in &panel.y.ticks {
        let y = top + height * (1.0 - panel.y.share(*value));
        group = group.add(line([left, y], [left + width, y], 0.4, "#e2e5ea"));
    }
    group
}

/// Edges, tick labels and names, which are above the data.
fn axes_above(panel: &Panel) -> Group {
    let [left, top, width, height] = panel.place;
    let (right, bottom) = (left + width, top + height);
    let mut group = Group::new();
    if !panel.caption.is_empty() {
        group = group.add(text_element([left, top - 3.0], &panel.caption, Anchor::Start, SMALL, GRAY));
    }
    if panel.frame == DrawnAxes::None {
        return group;
    }
    let gray = hex(GRAY);
    group = group.add(line([left, bottom], [right, bottom], 0.6, &gray)).add(line(
        [left, top],
        [left, bottom],
        0.6,
        &gray,
    ));
    for (value, name) in &panel.y.ticks {
        let y = top + height * (1.0 - panel.y.share(*value));
        group = group.add(line([left - 2.5, y], [left, y], 0.6, &gray)).add(text_element(
            [left - 4.0, y + 0.36 * SMALL],
            name,
            Anchor::End,
            SMALL,
            INK,
        ));
    }
    let middle = top + height / 2.0;
    let name = text_element([left - NAME, middle], &panel.y.name, Anchor::Middle, TEXT, INK);
    group = group.add(name.set("transform", format!("rotate(-90 {} {})", short(left - NAME), short(middle))));
    for (value, name) in &panel.x.ticks {
        let x = left + width * panel.x.share(*value);
        group = group.add(line([x, bottom], [x, bottom + 2.5], 0.6, &gray));
        if panel.frame == DrawnAxes::Axes {
            group = group.add(text_element([x, bottom + 10.0], name, Anchor::Middle, SMALL, INK));
        }
    }
    if panel.frame == DrawnAxes::Axes {
        group = group.add(text_element(
            [left + width / 2.0, bottom + 20.0],
            &panel.x.name,
            Anchor::Middle,
            TEXT,
            INK,
        ));
    }
    group
}

/// A legend's sign around its centre.
fn sign(key: &Key, [x, y]: [f64; 2]) -> Group {
    let colour = hex(key.colour);
    let patch = |opacity: f64| {
        rectangle([x - 6.0, y - 3.5, 12.0, 7.0])
            .set("fill", colour.as_str())
            .set("fill-opacity", short(opacity))
    };
    let ends = ([x - 6.0, y], [x + 6.0, y]);
    let group = Group::new();
    match key.sign {
        Sign::Patch(opacity) => group.add(patch(opacity)),
        Sign::Band => group.add(patch(0.3)).add(line(ends.0, ends.1, 1.2, &colour)),
        Sign::Line => group.add(line(ends.0, ends.1, 1.2, &colour)),
        Sign::Dashed => group.add(line(ends.0, ends.1, 1.2, &colour).set("stroke-dasharray", "3 2")),
        Sign::Dot | Sign::Ring => group.add(dot([x, y], 2.2, key.sign, &colour)),
        Sign::Cross => group.add(dot([x, y], 3.5, key.sign, &colour)),
    }
}

fn text_element(at: [f64; 2], text: &str, anchor: Anchor, size: f64, colour: Rgb) -> Text {
    let anchor = match anchor {
        Anchor::Start => "start",
        Anchor::Middle => "middle",
        Anchor::End => "end",
    };
    Text::new(text)
        .set("x", short(at[0]))
        .set("y", short(at[1]))
        .set("font-size", short(size))
        .set("text-anchor", anchor)
        .set("fill", hex(colour))
}

fn line(from: [f64; 2], to: [f64; 2], width: f64, colour: &str) -> Line {
    Line::new()
        .set("x1", short(from[0]))
        .set("y1", short(from[1]))
        .set("x2", short(to[0]))
        .set("y2", short(to[1]))
        .set("stroke", colour)
        .set("stroke-width", short(width))
}

fn rectangle([left, top, width, height]: [f64; 4]) -> Rectangle {
    Rectangle::new()
        .set("x", short(left))
        .set("y", short(top))
        .set("width", short(width))
        .set("height", short(height))
}

fn points_text(panel: &Panel, points: &[[f64; 2]]) -> String {
    let places = points.iter().map(|point| panel.at(*point));
    places.map(|[x, y]| format!("{},{}", short(x), short(y))).collect::<Vec<_>>().join(" ")
}

fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// A coordinate rounded to thousandths of a point.
fn short(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    (if text == "-0" { "0" } else { text }).to_owned()
}
