//! Layouts of views and panels.

use crate::app::model::view::View;

/// A row of views: its share of the height, and the tabs of each column.
pub(crate) type LayoutRow = (f32, &'static [&'static [View]]);

/// A layout for a purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum ViewLayout {
    /// All views: the initial layout.
    All,
    /// Six images of equal size without panels.
    Figure,
    /// Settings beside the views that they affect.
    Tuning,
    /// The results of two sets of settings on the same frame.
    Compare,
    /// One large image beside the pixel inspector.
    Inspect,
}

impl ViewLayout {
    /// Whether the settings panel and the inspector panel are open.
    pub(crate) const fn panels(self) -> (bool, bool) {
        match self {
            Self::All => (true, true),
            Self::Figure => (false, false),
            Self::Tuning | Self::Compare => (true, false),
            Self::Inspect => (false, true),
        }
    }

    /// The rows of views. They contain each view once, some as background tabs.
    pub(crate) const fn rows(self) -> &'static [LayoutRow] {
        use View::{
            Agreement, Background, ComparedBackground, ComparedForeground, ComparedTracks, Difference,
            ExternalAgreement, ExternalErrors, Foreground, Input, Map, MaskErrors, Regions, Tracks,
        };
        match self {
            Self::All => &[
                (1.0, &[&[Input], &[Background, Difference, Map, ComparedBackground]]),
                (
                    1.0,
                    &[
                        &[Foreground, ComparedForeground],
                        &[Regions, MaskErrors, Agreement, ExternalErrors, ExternalAgreement],
                    ],
                ),
                (1.6, &[&[Tracks, ComparedTracks]]),
            ],
            Self::Figure => &[
                (
                    1.0,
                    &[
                        &[Input],
                        &[Background, ComparedBackground],
                        &[Difference, Map, MaskErrors, Agreement, ExternalErrors, ExternalAgreement],
                    ],
                ),
                (1.0, &[&[Foreground, ComparedForeground], &[Regions], &[Tracks, ComparedTracks]]),
            ],
            Self::Tuning => &[
                (
                    1.0,
                    &[
                        &[Input, Background, Difference, Map, ComparedBackground],
                        &[
                            Foreground,
                            MaskErrors,
                            Regions,
                            ComparedForeground,
                            Agreement,
                            ExternalErrors,
                            ExternalAgreement,
                        ],
                    ],
                ),
                (1.0, &[&[Tracks, ComparedTracks]]),
            ],
            Self::Compare => &[
                (
                    1.0,
                    &[
                        &[Foreground, MaskErrors, Background, Regions],
                        &[Agreement, Input, Difference, Map, ExternalErrors, ExternalAgreement],
                        &[ComparedForeground, ComparedBackground],
                    ],
                ),
                (1.0, &[&[Tracks], &[ComparedTracks]]),
            ],
            Self::Inspect => &[
                (1.6, &[&[Input, Tracks, ComparedTracks]]),
                (
                    1.0,
                    &[
                        &[Background, Difference, ComparedBackground],
                        &[Foreground, MaskErrors, Regions, ComparedForeground],
                        &[Map, Agreement, ExternalErrors, ExternalAgreement],
                    ],
                ),
            ],
        }
    }
}
