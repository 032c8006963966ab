//! Assembles a picture: visible region, panels, color bars, title and marks.

use super::arrows::{arrows_into, factor, far_end, key_into, longest};
use super::marks::{Axes, TRIAD_ROOM, bar_into, triad_into};
use super::options::{Measure, Panel, PictureBounds, PictureOptions};
use super::scale::{INK, Scale, TEXT};
use super::skin::{Skin, cut_surface};
use super::view::{Bounds, Camera, View};
use super::{hull, plane};
use crate::dynamics::{BodyFields, PlacedObstacle};
use crate::output::drawing::{Anchor, Drawing, Ink, Line, Point, Stroke, elided};
use crate::output::obstacle_surfaces::ObstacleSurface;
use crate::output::obstacles::{Surroundings, Wall};

/// Margin in pixels.
const MARGIN: f64 = 14.0;
/// Size of the title in pixels.
const TITLE: f64 = 19.0;
/// Narrowest panel in pixels.
const NARROWEST: f64 = 240.0;
/// Ratio of width to height of the bodies above which panels are placed one below the other.
const WIDE: f64 = 1.6;
/// Largest distance from the bodies at which obstacles are still shown, relative to the extent of the bodies.
const NEIGHBORHOOD: f64 = 1.5;

/// Size of unbounded obstacles in space, from the center of the bodies, relative to their extent.
const REACH_IN_SPACE: f64 = 0.8;

/// Factor on `NEIGHBORHOOD` for obstacles in space.
const AS_A_WHOLE: f64 = 3.0;
/// Smallest and largest height of a color bar, in pixels.
const BAR: [f64; 2] = [120.0, 360.0];

/// Data common to all panels.
struct Layout<'a> {
    bodies: &'a [BodyFields],
    walls: Vec<Wall>,
    /// Visible surfaces of bodies in space.
    skins: Vec<Skin>,
    surfaces: Vec<ObstacleSurface>,
    /// Intersection lines of a section with obstacles.
    rims: Vec<[[f64; 3]; 2]>,
    options: &'a PictureOptions,
    is_plane: bool,
    bounds: Bounds,
    axes: Option<Axes>,
    /// Pixels per length.
    zoom: f64,
    /// Width and height of a panel in pixels.
    size: Point,
    /// Height of the area for the bodies in pixels.
    height: f64,
    /// Ratio of arrow length to vector length.
    arrow: f64,
}

/// Draws the bodies and the obstacles that they touch.
pub fn picture(bodies: &[BodyFields], obstacles: &[PlacedObstacle], options: &PictureOptions) -> Drawing {
    let bodies: &[BodyFields] = &options.shown_of(bodies);
    let values: Vec<Vec<Vec<f64>>> = options.panels.iter().map(|panel| panel_values(bodies, panel)).collect();
    let unit = |panel: &Panel| if panel.unit.is_empty() { String::new() } else { format!(" [{}]", panel.unit) };
    let scale = |(panel, values): (&Panel, &Vec<Vec<f64>>)| {
        let label = format!("{}{}", panel.field.words(), unit(panel));
        match panel.range {
            _ if !panel.field.kinds().is_empty() => Scale::of_kinds(panel.field.kinds(), &label),
            _ if values.iter().all(Vec::is_empty) => Scale::blank(),
            Some(range) => Scale::new(range, &label),
            None => Scale::new(values.iter().flatten().copied(), &label),
        }
    };
    let scales: Vec<Scale> = options.panels.iter().zip(&values).map(scale).collect();
    let width = options.width.max(NARROWEST);
    let bar = scales.iter().map(Scale::width).fold(0.0, f64::max);
    let (mut layout, columns) = Layout::new(bodies, obstacles, options, width, bar);
    let top = if options.title.is_empty() { 0.0 } else { MARGIN + TITLE };
    // All rows must stay within the largest size of a picture.
    layout.size[1] = layout.size[1].ceil();
    let rows = options.panels.len().div_ceil(columns).max(1);
    let mut out = Drawing::new([width, top + rows as f64 * layout.size[1]]);
    if !options.title.is_empty() {
        out.text([MARGIN, MARGIN + TITLE - 3.0], elided(&options.title, TITLE, width - 2.0 * MARGIN), TITLE, Anchor::Start);
    }
    for (index, (scale, values)) in scales.iter().zip(&values).enumerate() {
        let corner = [(index % columns) as f64 * layout.size[0], top + (index / columns) as f64 * layout.size[1]];
        layout.panel_into(&mut out, corner, values, scale, bar);
    }
    out
}

/// Returns the visible region of a picture of these bodies, to be joined with those of other pictures ([`PictureBounds::with`]).
pub fn sight(bodies: &[BodyFields], obstacles: &[PlacedObstacle], options: &PictureOptions) -> PictureBounds {
    let bodies: &[BodyFields] = &options.shown_of(bodies);
    let (layout, _) = Layout::new(bodies, obstacles, options, options.width.max(NARROWEST), 0.0);
    PictureBounds { bounds: layout.bounds, longest: options.vectors.as_ref().map_or(0.0, |(vectors, _)| longest(bodies, *vectors)) }
}

/// Values at the nodes of each body; none for a body that does not have the field.
fn panel_values(bodies: &[BodyFields], panel: &Panel) -> Vec<Vec<f64>> {
    let nodes = |body: &BodyFields| if panel.field.is_of(body) { 0..body.mesh.points.len() } else { 0..0 };
    bodies.iter().map(|body| nodes(body).map(|node| panel.field.value(body, node, &panel.frame)).collect()).collect()
}

impl<'a> Layout<'a> {
    /// Returns the layout, and the number of panels side by side.
    fn new(bodies: &'a [BodyFields], obstacles: &[PlacedObstacle], options: &'a PictureOptions, width: f64, bar: f64) -> (Self, usize) {
        let is_plane = bodies.iter().all(|body| body.mesh.dimension() == 2);
        let view = if is_plane { View::PLANE } else { options.view };
        let mut points: Vec<Point> = Vec::new();
        let in_space = Surroundings::of_bodies(bodies);
        let section = options.section.filter(|_| !is_plane).map(|section| section.through(in_space.middle));
        let skin = |body: &BodyFields| Skin::new(body, |node| body.position(node), section.as_ref());
        let skins: Vec<Skin> = bodies.iter().filter(|_| !is_plane).map(skin).collect();
        for (index, body) in bodies.iter().enumerate() {
            match skins.get(index).filter(|_| section.is_some()) {
                Some(skin) => points.extend(skin.seen().map(|point| view.flat(point))),
                None => points.extend((0..body.mesh.points.len()).map(|node| view.flat(body.position(node)))),
            }
            if options.is_undeformed_shown {
                points.extend(body.mesh.points.iter().map(|&point| view.flat(point)));
            }
        }
        let own = Bounds::of(points.iter());
        let around = match &options.sight {
            Some(sight) => Surroundings::of([sight.bounds.low, sight.bounds.high()].into_iter().map(|[x, y]| [x, y, 0.0])),
            None => Surroundings::of(points.iter().map(|&[x, y]| [x, y, 0.0])),
        };
        let walls: Vec<Wall> = obstacles.iter().filter_map(|obstacle| Wall::new(obstacle, &around, 2.0 * NEIGHBORHOOD)).collect();
        let mut surfaces: Vec<ObstacleSurface> =
            obstacles.iter().filter_map(|obstacle| ObstacleSurface::new(obstacle, &in_space, REACH_IN_SPACE)).collect();
        let mut rims = Vec::new();
        if let Some(section) = &section {
            let cut: (Vec<_>, Vec<_>) = surfaces.into_iter().map(|surface| cut_surface(surface, section)).unzip();
            (surfaces, rims) = (cut.0, cut.1.concat());
        }
        let reach = NEIGHBORHOOD * own.size[0].max(own.size[1]);
        let (low, high) = (own.low, own.high());
        let is_within = |point: &Point, reach: f64| (0..2).all(|d| (low[d] - reach..=high[d] + reach).contains(&point[d]));
        let is_near = |point: &Point| is_within(point, reach);
        // A half plane contributes its points near the bodies to the visible region, not its far ends.
        let landmarks = |wall: &Wall| wall.landmarks(low, high).into_iter().filter(is_near).collect::<Vec<_>>();
        points.extend(walls.iter().filter(|wall| wall.border.len() > 2).flat_map(landmarks));
        for wall in walls.iter().filter(|wall| wall.border.len() <= 2) {
            let ends = wall.landmarks(low, high).into_iter().filter(|point| !wall.border.contains(point) && is_near(point));
            points.extend(ends);
        }
        let shown = surfaces.iter().flat_map(|surface| &surface.points).map(|&point| view.flat(point));
        points.extend(shown.filter(|point| is_within(point, AS_A_WHOLE * reach)));
        let mut arrow = 0.0;
        if let Some((vectors, _)) = &options.vectors {
            arrow = factor(longest(bodies, *vectors), own.size[0].max(own.size[1]));
            let ends = |body: &'a BodyFields| (0..body.mesh.points.len()).map(move |node| far_end(body, node, *vectors, arrow));
            points.extend(bodies.iter().flat_map(ends).map(|end| view.flat(end)));
        }
        let mut bounds = Bounds::of(points.iter());
        if let Some(sight) = &options.sight {
            bounds = sight.bounds;
            arrow = factor(sight.longest, bounds.size[0].max(bounds.size[1]));
        }
        let count = options.panels.len().max(1);
        let fits = ((width / NARROWEST) as usize).max(1);
        let columns = if bounds.size[0] > WIDE * bounds.size[1] { 1 } else { count.min(2).min(fits) };
        let panel = (width / columns as f64).max(NARROWEST);
        let (size, axes, zoom, height) = ([panel, 0.0], None, 1.0, 0.0);
        let mut layout = Layout { bodies, walls, skins, surfaces, rims, options, is_plane, bounds, axes, zoom, size, height, arrow };
        layout.zoom = layout.fitting(panel - 3.0 * MARGIN - bar, panel);
        if is_plane && options.measure == Measure::Axes {
            let axes = Axes::over(bounds.low, bounds.high(), layout.zoom, &options.length_unit);
            layout.zoom = layout.fitting(panel - 3.0 * MARGIN - bar - axes.width(), panel);
            layout.axes = Some(axes);
        }
        layout.height = (bounds.size[1] * layout.zoom).max(BAR[0] + 60.0);
        layout.size[1] = layout.height + 2.0 * MARGIN + layout.footer();
        (layout, columns)
    }

    fn fitting(&self, width: f64, height: f64) -> f64 {
        (width.max(1.0) / self.bounds.size[0]).min(height / self.bounds.size[1])
    }

    /// Height of the scale bar, triad and key below the bodies.
    fn footer(&self) -> f64 {
        let axes = if self.axes.is_some() { Axes::HEIGHT } else { 0.0 };
        let bar = self.options.measure == Measure::Bar || self.options.vectors.is_some();
        let line = match (self.is_plane, bar) {
            (false, _) => 2.0 * TRIAD_ROOM,
            (true, true) => TEXT + 14.0,
            (true, false) => 0.0,
        };
        axes + line
    }

    /// Draws one field in a panel with the upper left corner `corner`.
    fn panel_into(&self, out: &mut Drawing, corner: Point, values: &[Vec<f64>], scale: &Scale, bar: f64) {
        let left = corner[0] + MARGIN + self.axes.as_ref().map_or(0.0, Axes::width);
        let right = corner[0] + self.size[0] - 2.0 * MARGIN - bar;
        let (top, drawn) = (corner[1] + MARGIN, self.bounds.size.map(|size| size * self.zoom));
        let camera = Camera {
            view: if self.is_plane { View::PLANE } else { self.options.view },
            bounds: self.bounds,
            corner: [left + 0.5 * (right - left - drawn[0]).max(0.0), top + 0.5 * (self.height + drawn[1])],
            zoom: self.zoom,
        };
        let options = self.options;
        out.begin_clipped([left - 2.0, top - 2.0], [right + 2.0, top + self.height + 2.0]);
        for wall in &self.walls {
            plane::wall_into(out, wall, &camera);
        }
        if self.is_plane {
            for (body, values) in self.bodies.iter().zip(values) {
                out.begin_named(&body.name);
                plane::body_into(out, body, values, &camera, scale, options.is_meshed);
                if scale.has_kinds() {
                    plane::kinds_into(out, body, values, &camera, scale);
                }
                out.end();
            }
        } else {
            hull::bodies_into(out, (&self.skins, &self.surfaces), values, &camera, scale, options.is_meshed);
            let rims = self.rims.iter().map(|&rim| Line::open(rim.map(|point| camera.place(point)))).collect();
            out.paint(rims, Ink::Stroke(Stroke::new(INK, 1.1)));
        }
        if options.is_undeformed_shown && self.is_plane {
            self.bodies.iter().for_each(|body| plane::undeformed_into(out, body, &camera));
        } else if options.is_undeformed_shown {
            let skin = |body: &BodyFields| Skin::new(body, |node| body.mesh.points[node], None);
            hull::undeformed_into(out, &self.bodies.iter().map(skin).collect::<Vec<_>>(), &camera);
        }
        if let Some((vectors, _)) = &options.vectors {
            arrows_into(out, (self.bodies, &self.skins), *vectors, &camera, self.arrow);
        }
        out.end();
        if let Some(axes) = &self.axes {
            axes.draw_into(out, &camera);
        }
        self.footer_into(out, [corner[0] + MARGIN, corner[1] + self.size[1] - MARGIN], &camera);
        let height = self.height.clamp(BAR[0], BAR[1]);
        scale.bar_into(out, [right + MARGIN, top + 0.5 * (self.height - height)], height);
    }

    /// Draws the scale bar, the triad and the key of the arrows, with the lower left corner at the given point.
    fn footer_into(&self, out: &mut Drawing, [mut x, bottom]: Point, camera: &Camera) {
        let end = x + self.size[0] - 2.0 * MARGIN;
        let mut y = bottom - 0.5 * TEXT;
        if !self.is_plane {
            triad_into(out, [x + TRIAD_ROOM, bottom - TRIAD_ROOM], &camera.view);
            x += 2.0 * TRIAD_ROOM + 20.0;
            y = bottom - TRIAD_ROOM;
        }
        if self.options.measure == Measure::Bar {
            x += bar_into(out, [x, y], self.zoom, self.size[0], &self.options.length_unit) + 36.0;
        }
        if let Some((vectors, unit)) = &self.options.vectors {
            let longest = self.options.sight.map_or_else(|| longest(self.bodies, *vectors), |sight| sight.longest);
            key_into(out, longest, *vectors, unit, [x, y], end - x);
        }
    }
}
