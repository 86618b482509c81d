//! The parameters that controllers have in common.

/// [`params!`](crate::params!) of a controller, with the distances that each of them has; `with
/// search`, the paper's search for the lookahead point comes before them.
macro_rules! law_params {
    (
        $(#[doc = $about:literal])+
        pub struct $name:ident<Scaled> of $whole:ident($wheelbase:ident $(, $car:ident)*) { $($fields:tt)+ }
        with search
    ) => {
        $crate::laws::params::law_params! {
            $(#[doc = $about])+
            pub struct $name<Scaled> of $whole($wheelbase $(, $car)*) {
                $($fields)+
                /// Whether the lookahead point is the path's first crossing of the circle ahead of
                /// the vehicle, instead of what the paper's search finds.
                exact_lookahead: bool = true;
                /// Threshold epsilon of the paper's search [m].
                lookahead_tolerance: Scaled = $wheelbase / 300.0, in [1e-9, 1e3];
                /// Arc ahead of the vehicle that the paper's search looks at [m].
                window_ahead: Scaled = 20.0 / 3.0 * $wheelbase, in [1e-3, 1e6];
                /// Greatest distance of neighbours on the path as the paper's search
                /// re-discretises it [m].
                grid_spacing: Scaled = $wheelbase / 300.0, in [1e-6, 1e3];
            }
        }
    };
    (
        $(#[doc = $about:literal])+
        pub struct $name:ident<Scaled> of $whole:ident($wheelbase:ident $(, $car:ident)*) { $($fields:tt)+ }
    ) => {
        $crate::params! {
            $(#[doc = $about])+
            pub struct $name<Scaled> of $whole($wheelbase $(, $car)*) {
                $($fields)+
                /// Arc of the path that is searched on each side of the last projection [m], in
                /// addition to the distance travelled in a step.
                search_distance: Scaled = 2.0 * $wheelbase, in [0.0, 1e6];
                /// Distance from the path beyond which the vehicle is lost and is searched for on
                /// the whole path [m].
                lost_distance: Scaled = 10.0 * $wheelbase, in [1e-3, 1e9];
            }
        }
    };
}
pub(super) use law_params;
