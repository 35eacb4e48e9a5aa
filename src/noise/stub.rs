//! Temporary.
use super::{Field, Isa};
impl Field {
    /// x
    pub fn range(&self) -> [f32; 2] {
        [-1e3, 1e3]
    }
    /// x
    pub fn max_slope(&self) -> f32 {
        100.0
    }
    /// x
    pub fn points(&self, _isa: Isa, us: &[f64], vs: &[f64], out: &mut [f32]) {
        for (o, (&u, &v)) in out.iter_mut().zip(us.iter().zip(vs)) {
            *o = self.at(u, v);
        }
    }
    /// x
    pub fn slopes_at(&self, u: f64, v: f64) -> [f32; 2] {
        let d = 1e-4;
        [(self.at(u + d, v) - self.at(u - d, v)) / 2e-4, (self.at(u, v + d) - self.at(u, v - d)) / 2e-4]
    }
    /// x
    pub fn slope_points(&self, _isa: Isa, us: &[f64], vs: &[f64], du: &mut [f32], dv: &mut [f32]) {
        for (i, (&u, &v)) in us.iter().zip(vs).enumerate() {
            [du[i], dv[i]] = self.slopes_at(u, v);
        }
    }
}
