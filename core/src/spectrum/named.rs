use super::Medium;

impl Medium {
    /// Fused silica: Malitson 1965.
    pub const FUSED_SILICA: Self = Self::known(
        [210.0, 6700.0],
        0.0,
        [0.696_166_3, 0.407_942_6, 0.897_479_4, 0.0],
        [0.004_679_148, 0.013_512_063, 97.934, 0.0],
    );

    /// Crystal quartz, the ordinary ray: Ghosh 1999.
    pub const QUARTZ_O: Self = Self::known(
        [198.0, 2053.1],
        0.286_041_4,
        [1.070_440_8, 1.102_022_4, 0.0, 0.0],
        [0.010_058_6, 100.0, 0.0, 0.0],
    );

    /// Crystal quartz, the extraordinary ray: Ghosh 1999.
    pub const QUARTZ_E: Self = Self::known(
        [198.0, 2053.1],
        0.288_518_04,
        [1.095_099_2, 1.156_624_8, 0.0, 0.0],
        [0.010_210_186, 100.0, 0.0, 0.0],
    );

    /// N-BK7, a crown: Schott.
    pub const N_BK7: Self = Self::known(
        [300.0, 2500.0],
        0.0,
        [1.039_612, 0.231_792_34, 1.010_469_5, 0.0],
        [0.006_000_699, 0.020_017_914, 103.560_65, 0.0],
    );

    /// SF11, a dense flint: Schott. It is not known below 390 nm.
    pub const SF11: Self = Self::known(
        [390.0, 2500.0],
        0.0,
        [1.738_484, 0.311_168_97, 1.174_908_7, 0.0],
        [0.013_606_86, 0.061_596_046, 121.922_71, 0.0],
    );

    /// Diamond: Peter 1923.
    pub const DIAMOND: Self = Self::known(
        [226.0, 760.0],
        0.0,
        [0.330_6, 4.335_6, 0.0, 0.0],
        [0.030_625, 0.011_236, 0.0, 0.0],
    );

    /// Water of 20 °C: Daimon & Masumura 2007.
    pub const WATER: Self = Self::known(
        [182.0, 1129.0],
        0.0,
        [0.568_402_76, 0.172_617_74, 0.020_861_896, 0.113_074_87],
        [0.005_101_83, 0.018_211_54, 0.026_207_223, 10.697_927],
    );

    /// The media that are built in, by the names that commands and scenes have
    /// for them.
    pub const NAMED: [(&'static str, Self); 7] = [
        ("fused-silica", Self::FUSED_SILICA),
        ("quartz-o", Self::QUARTZ_O),
        ("quartz-e", Self::QUARTZ_E),
        ("n-bk7", Self::N_BK7),
        ("sf11", Self::SF11),
        ("diamond", Self::DIAMOND),
        ("water", Self::WATER),
    ];

    /// The medium of a name of [`NAMED`](Self::NAMED).
    pub fn named(name: &str) -> Option<Self> {
        let found = Self::NAMED.iter().find(|(known, _)| *known == name);
        found.map(|&(_, medium)| medium)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Catalogues' coefficients: the form, A, then pairs of B and C.
    const CATALOGUE: [(u32, f64, &[[f64; 2]]); 7] = [
        (
            1,
            0.0,
            &[
                [0.696_166_3, 0.068_404_3],
                [0.407_942_6, 0.116_241_4],
                [0.897_479_4, 9.896_161],
            ],
        ),
        (
            2,
            0.286_041_41,
            &[[1.070_440_83, 1.005_859_97e-2], [1.102_022_42, 100.0]],
        ),
        (
            2,
            0.288_518_04,
            &[[1.095_099_24, 1.021_018_64e-2], [1.156_624_75, 100.0]],
        ),
        (
            2,
            0.0,
            &[
                [1.039_612_12, 0.006_000_698_67],
                [0.231_792_344, 0.020_017_914_4],
                [1.010_469_45, 103.560_653],
            ],
        ),
        (
            2,
            0.0,
            &[
                [1.738_484_03, 0.013_606_860_4],
                [0.311_168_974, 0.061_596_046_3],
                [1.174_908_71, 121.922_711],
            ],
        ),
        (1, 0.0, &[[0.330_6, 0.175_0], [4.335_6, 0.106_0]]),
        (
            2,
            0.0,
            &[
                [0.568_402_756_5, 5.101_829_712e-3],
                [0.172_617_739_1, 1.821_153_936e-2],
                [2.086_189_578e-2, 2.620_722_293e-2],
                [0.113_074_868_8, 10.697_927_21],
            ],
        ),
    ];

    fn exact((form, a, terms): (u32, f64, &[[f64; 2]]), nm: f64) -> f64 {
        let square = (nm / 1000.0) * (nm / 1000.0);
        let terms = terms.iter().map(|&[b, c]| {
            let c = if form == 1 { c * c } else { c };
            b * square / (square - c)
        });
        libm::sqrt(1.0 + a + terms.sum::<f64>())
    }

    #[test]
    fn media_have_their_catalogues_index() {
        let steps = if cfg!(miri) { 50 } else { 20_000 };
        for ((name, medium), catalogue) in Medium::NAMED.into_iter().zip(CATALOGUE) {
            assert_eq!(Medium::named(name), Some(medium));
            let [low, high] = medium.range();
            let mut worst = 0f64;
            for i in 0..=steps {
                let nm = low + (high - low) * i as f32 / steps as f32;
                let exact = exact(catalogue, f64::from(nm));
                worst = worst.max((f64::from(medium.index(nm)) / exact - 1.0).abs());
            }
            assert!(worst <= 2.8e-7, "{name}: {worst}");
        }
        assert_eq!(Medium::named("glass"), None);
    }
}
