//! Names of points beside them, where there is room.

use shisen::picture::chart::Corner;

/// The width of a letter and the height of a line, as parts of the chart's width and height.
const LETTER: f64 = 0.0155;
const LINE: f64 = 0.052;

/// Half the width and the height of a dot.
const DOT: (f64, f64) = (0.012, 0.018);

/// The distance from a dot to its name.
const ASIDE: (f64, f64) = (0.017, 0.012);

pub(super) struct Room {
    taken: Vec<Block>,
}

#[derive(Debug, Clone, Copy)]
struct Block {
    x: (f64, f64),
    y: (f64, f64),
}

impl Room {
    pub(super) fn new(dots: &[(f64, f64)]) -> Self {
        let dot = |&(x, y): &(f64, f64)| Block {
            x: (x - DOT.0, x + DOT.0),
            y: (y - DOT.1, y + DOT.1),
        };
        Self {
            taken: dots.iter().map(dot).collect(),
        }
    }

    /// Takes room for a name beside a dot; `None` where every side is taken.
    pub(super) fn take(&mut self, (x, y): (f64, f64), name: &str) -> Option<Corner> {
        let wide = LETTER * name.chars().count() as f64;
        let right = (x + ASIDE.0, x + ASIDE.0 + wide);
        let left = (x - ASIDE.0 - wide, x - ASIDE.0);
        let upper = (y + ASIDE.1, y + ASIDE.1 + LINE);
        let lower = (y - ASIDE.1 - LINE, y - ASIDE.1);
        let sides = [
            (Corner::UpperRight, right, upper),
            (Corner::UpperLeft, left, upper),
            (Corner::LowerRight, right, lower),
            (Corner::LowerLeft, left, lower),
        ];
        let (side, block) = sides
            .into_iter()
            .map(|(side, x, y)| (side, Block { x, y }))
            .find(|(_, block)| self.is_free(*block))?;
        self.taken.push(block);
        Some(side)
    }

    fn is_free(&self, block: Block) -> bool {
        let inside = |(low, high): (f64, f64)| low >= 0.0 && high <= 1.0;
        let apart = |a: (f64, f64), b: (f64, f64)| a.1 <= b.0 || b.1 <= a.0;
        let clear = |other: &Block| apart(block.x, other.x) || apart(block.y, other.y);
        inside(block.x) && inside(block.y) && self.taken.iter().all(clear)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stand_where_nothing_else_does() {
        let dots = [(0.5, 0.5), (0.55, 0.54)];
        let mut room = Room::new(&dots);
        // The other dot is up and to the right of it.
        assert_eq!(room.take(dots[0], "first"), Some(Corner::UpperLeft));
        assert_eq!(room.take(dots[1], "second"), Some(Corner::UpperRight));
        // The names are in the way of others now.
        assert_eq!(room.take((0.5, 0.5), "third"), Some(Corner::LowerRight));
        assert_eq!(room.take((0.5, 0.5), "fourth"), Some(Corner::LowerLeft));
        assert_eq!(room.take((0.5, 0.5), "fifth"), None);
    }
}
