//! All screens in one picture: unfolded into a [`net`], or as the [`viewer`] sees them.

pub mod net;
pub mod viewer;

#[cfg(test)]
mod walls {
    use crate::cave::Wall;
    use crate::picture::Picture;
    use glam::DVec3;

    pub(super) fn wall(name: &str, [lower_left, lower_right, upper_left]: [[f64; 3]; 3]) -> Wall {
        Wall {
            name: name.to_owned(),
            lower_left: lower_left.into(),
            lower_right: lower_right.into(),
            upper_left: upper_left.into(),
            pixels: [0, 0],
        }
    }

    pub(super) fn cube<const N: usize>(names: [&str; N]) -> [Wall; N] {
        names.map(|name| {
            let corners = match name {
                "front" => [[-1., -1., -1.], [1., -1., -1.], [-1., 1., -1.]],
                "left" => [[-1., -1., 1.], [-1., -1., -1.], [-1., 1., 1.]],
                "right" => [[1., -1., -1.], [1., -1., 1.], [1., 1., -1.]],
                "back" => [[1., -1., 1.], [-1., -1., 1.], [1., 1., 1.]],
                "floor" => [[-1., -1., 1.], [1., -1., 1.], [-1., -1., -1.]],
                _ => [[-1., 1., -1.], [1., 1., -1.], [-1., 1., 1.]],
            };
            wall(name, corners)
        })
    }

    pub(super) fn painted(
        wall: &Wall,
        [width, height]: [u32; 2],
        colour: impl Fn(DVec3) -> [f32; 4],
    ) -> Picture {
        let mut picture = Picture::new(width, height).unwrap();
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let along = (f64::from(x) + 0.5) / f64::from(width);
            let up = 1.0 - (f64::from(y) + 0.5) / f64::from(height);
            let point = wall.lower_left
                + along * (wall.lower_right - wall.lower_left)
                + up * (wall.upper_left - wall.lower_left);
            picture.set_pixel(x, y, colour(point));
        }
        picture
    }
}
