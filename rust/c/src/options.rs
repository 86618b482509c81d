//! How a controller adapts to its vehicle, and watches it.

use popsteer_core::error::{ConfigError, Requirement};
use popsteer_core::laws::Law;
use popsteer_core::tracker::{MonitorParams, Tracker};
use popsteer_core::vehicle::AdaptParams;

use crate::error::Failure;
use crate::fields::{Field, c_type};

/// Of `popsteer_options.adapt` and `.monitor`: as controllers of this kind do; the default.
pub const POPSTEER_AUTO: u32 = 0;
/// Of `popsteer_options.adapt` and `.monitor`: not at all.
pub const POPSTEER_OFF: u32 = 1;
/// Of `popsteer_options.adapt` and `.monitor`: with the numbers beside it.
pub const POPSTEER_ON: u32 = 2;

/// Hands the numbers of adapting on, to those of the monitor.
macro_rules! adapting {
    ({} $($numbers:tt)+) => {
        popsteer_core::MonitorParams! { options { $($numbers)+ } }
    };
}

/// The struct of C with the numbers that the core declares.
macro_rules! options {
    ({$(
        $(#[doc = $adapt_text:literal])+
        $adapt:ident: $adapt_kind:ident $(<$adapt_of:ty>)? = $adapt_default:expr
        $(, in [$adapt_low:expr, $adapt_high:expr])?;
    )+} $(
        $(#[doc = $text:literal])+
        $monitor:ident: $kind:ident $(<$of:ty>)? = $default:expr $(, in [$low:expr, $high:expr])?;
    )+) => {
        /// How a controller adapts to its vehicle, and watches it.
        #[repr(C)]
        #[derive(Clone, Copy, Debug)]
        pub struct COptions {
            /// Whether it adapts: one of the three above.
            pub adapt: u32,
            /// Whether it watches: one of the three above.
            pub monitor: u32,
            $($(#[doc = $adapt_text])+ pub $adapt: c_type!($adapt_kind),)+
            $($(#[doc = $text])+ pub $monitor: c_type!($kind),)+
        }

        impl Default for COptions {
            fn default() -> Self {
                Self {
                    adapt: POPSTEER_AUTO,
                    monitor: POPSTEER_AUTO,
                    $($adapt: Field::of(AdaptParams::DEFAULT.$adapt),)+
                    $($monitor: Field::of(MonitorParams::DEFAULT.$monitor),)+
                }
            }
        }

        impl COptions {
            fn params(self) -> (AdaptParams, MonitorParams) {
                (
                    AdaptParams { $($adapt: self.$adapt.to_core()),+ },
                    MonitorParams { $($monitor: self.$monitor.to_core()),+ },
                )
            }
        }
    };
}

popsteer_core::AdaptParams! { adapting {} }

impl COptions {
    /// The tracker of `law` with these options.
    pub(crate) fn track(self, law: &Law) -> Result<Tracker<Law>, Failure> {
        let (adapt, monitor) = self.params();
        let tracker = match self.adapt {
            POPSTEER_AUTO => Tracker::of(*law),
            POPSTEER_OFF => Tracker::new(*law, None)?,
            POPSTEER_ON => Tracker::new(*law, Some(adapt))?,
            other => return Err(no_switch("adapt", other)),
        };
        Ok(match self.monitor {
            POPSTEER_AUTO => tracker,
            POPSTEER_OFF => tracker.monitored(None)?,
            POPSTEER_ON => tracker.monitored(Some(monitor))?,
            other => return Err(no_switch("monitor", other)),
        })
    }
}

fn no_switch(field: &'static str, value: u32) -> Failure {
    Failure::Config(ConfigError {
        field,
        value: value.into(),
        requirement: Requirement::CountInRange(0, 2),
    })
}

/// The defaults of `popsteer_options`.
#[unsafe(no_mangle)]
pub extern "C" fn popsteer_options_default() -> COptions {
    COptions::default()
}
