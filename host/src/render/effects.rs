//! The choice of effects, and the shading compiled for them.
//!
//! On a command line they are a list: `auto`, the effects that the scene asks for; `all`, every
//! effect that is built; `-NAME` and `+NAME`, without and with one. An effect that the scene does
//! not ask for changes no pixel.

use crate::files::description::suggestion;
use shisen_core::COMPILED;
use shisen_core::scene::EffectSet;
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// A choice of effects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Effects {
    /// Every effect that is built, not only those that the scene asks for.
    everything: bool,
    with: EffectSet,
    without: EffectSet,
}

/// Why a list of effects cannot be read, and what to write instead.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct EffectsError(String);

impl Effects {
    /// The effects that the scene asks for.
    pub const AUTO: Self = Self {
        everything: false,
        with: EffectSet::NONE,
        without: EffectSet::NONE,
    };

    /// Every effect that is built, even if the scene does not ask for it: the same
    /// picture, at the cost of checking for each effect.
    pub const ALL: Self = Self {
        everything: true,
        ..Self::AUTO
    };

    /// Takes effects away.
    #[must_use]
    pub const fn less(mut self, effects: EffectSet) -> Self {
        self.with = self.with.difference(effects);
        self.without = self.without.union(effects);
        self
    }

    /// Adds effects.
    #[must_use]
    pub const fn more(mut self, effects: EffectSet) -> Self {
        self.without = self.without.difference(effects);
        self.with = self.with.union(effects);
        self
    }

    /// Returns the effects carried out in a scene that asks for `asked`.
    pub const fn of(&self, asked: EffectSet) -> EffectSet {
        let all = if self.everything {
            EffectSet::ALL
        } else {
            asked
        };
        all.union(self.with).difference(self.without)
    }
}

impl FromStr for Effects {
    type Err = EffectsError;

    fn from_str(text: &str) -> Result<Self, EffectsError> {
        let mut effects = Self::AUTO;
        for item in text.split(',').map(str::trim) {
            effects = match (item, item.strip_prefix('+'), item.strip_prefix('-')) {
                ("auto", ..) => Self::AUTO,
                ("all", ..) => Self::ALL,
                (_, Some(name), _) => effects.more(named(name)?),
                (_, _, Some(name)) => effects.less(named(name)?),
                _ => {
                    named(item)?;
                    return Err(EffectsError(format!(
                        "\"{item}\" is neither auto nor all: write +{item} or -{item}"
                    )));
                }
            };
        }
        Ok(effects)
    }
}

impl fmt::Display for Effects {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.everything { "all" } else { "auto" })?;
        let signed = |sign: char, effects: EffectSet| effects.names().map(move |name| (sign, name));
        for (sign, name) in signed('+', self.with).chain(signed('-', self.without)) {
            write!(f, ",{sign}{name}")?;
        }
        Ok(())
    }
}

fn named(name: &str) -> Result<EffectSet, EffectsError> {
    EffectSet::named(name).ok_or_else(|| {
        let help = suggestion(name, EffectSet::ALL.names()).unwrap_or_default();
        EffectsError(format!("there is no effect \"{name}\": {help}"))
    })
}

/// Returns the smallest compiled set of effects that has those wanted.
pub fn compiled_for(wanted: EffectSet) -> EffectSet {
    let mut sets = COMPILED.iter().copied();
    sets.find(|set| set.contains(wanted))
        .unwrap_or(EffectSet::ALL)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MIRRORS: EffectSet = EffectSet::SHADOWS.union(EffectSet::REFLECTION);

    #[test]
    fn lists_are_read_in_order() {
        let without_lines = EffectSet::ALL.difference(EffectSet::GRATICULE);
        for (text, expected) in [
            ("auto", MIRRORS),
            ("all", EffectSet::ALL),
            ("-shadows", EffectSet::REFLECTION),
            ("-shadows,+shadows", MIRRORS),
            ("+refraction", MIRRORS | EffectSet::REFRACTION),
            ("-shadows,auto", MIRRORS),
            ("all,-graticule", without_lines),
        ] {
            let effects: Effects = text.parse().unwrap();
            assert_eq!(effects.of(MIRRORS), expected, "{text}");
        }
        for text in ["auto", "all,-graticule", "auto,+refraction,-shadows"] {
            assert_eq!(text.parse::<Effects>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn what_is_no_effect_is_named() {
        for (text, expected) in [
            ("-shadow", "no effect \"shadow\": did you mean \"shadows\"?"),
            ("+caustics", "no effect \"caustics\": use one of: shadows,"),
            ("shadows", "write +shadows or -shadows"),
            ("Auto", "no effect \"Auto\""),
        ] {
            let error = text.parse::<Effects>().unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
