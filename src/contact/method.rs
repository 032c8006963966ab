//! A contact method as a row of the catalogue [`METHODS`](super::METHODS): name, summary, kernel constructors, guaranteed properties.

use std::fmt;

use super::kernel::ContactKernel;
use super::space::ProxySurfacesInSpace;

/// Makes the kernel for two surfaces in the plane, given by their facets and sized in the reference positions.
pub type MakeKernel = fn(secondary: &[[u32; 2]], primary: &[[u32; 2]], reference: &[f64]) -> Box<dyn ContactKernel>;

/// Makes the kernel for two surfaces in space.
pub type MakeKernelInSpace = fn(seen: &ProxySurfacesInSpace) -> Box<dyn ContactKernel>;

/// Discretization of the contact conditions between two surfaces.
pub struct ContactMethod {
    /// Name as written in a script.
    pub name: &'static str,
    /// One sentence for the reference.
    pub summary: &'static str,
    /// Constructor of the kernel in the plane.
    pub kernel: MakeKernel,
    /// Constructor of the kernel in space; `None` for methods of the plane.
    pub in_space: Option<MakeKernelInSpace>,
    /// True if each constraint is the gap of one secondary node: corners of the secondary side need no further constraints then.
    pub is_nodal: bool,
    /// True if a constant pressure is transferred exactly across nonmatching meshes (contact patch test).
    pub passes_patch_test: bool,
}

impl PartialEq for ContactMethod {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl fmt::Debug for ContactMethod {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        out.write_str(self.name)
    }
}
