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

    /// Returns the medium of a name of [`NAMED`](Self::NAMED).
    pub fn named(name: &str) -> Option<Self> {
        let found = Self::NAMED.iter().find(|(known, _)| *known == name);
        found.map(|&(_, medium)| medium)
    }
}
