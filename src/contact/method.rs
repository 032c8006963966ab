//! A contact method as a row of a catalogue: its name, its constraint functions, what it promises.

use std::fmt;

use super::kernel::ContactKernel;
use super::space::SeenInSpace;

/// Makes the constraint functions between two surfaces that are given by their facets, sized in the reference positions.
pub type MakeKernel = fn(secondary: &[[u32; 2]], primary: &[[u32; 2]], reference: &[f64]) -> Box<dyn ContactKernel>;

/// The same between two surfaces in space.
pub type MakeKernelInSpace = fn(seen: &SeenInSpace) -> Box<dyn ContactKernel>;

/// How contact conditions between two surfaces are discretized.
pub struct ContactMethod {
    /// Name as written in a script.
    pub name: &'static str,
    /// One sentence for the reference.
    pub summary: &'static str,
    /// Its constraint functions in the plane.
    pub kernel: MakeKernel,
    /// Those in space, if it has them.
    pub in_space: Option<MakeKernelInSpace>,
    /// Whether each constraint is the gap of one secondary node alone: its corners need no constraints of their own then.
    pub is_nodal: bool,
    /// Whether it carries a constant pressure across meshes that do not match (contact patch test).
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
