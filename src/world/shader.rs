//! A world's base as a shader.

use super::World;
use crate::programme::{Frame, Ground, ShaderError, ShaderLanguage};

impl World {
    /// Source text that computes the base's elevations, in metres, without the layers over it, as the text itself says: see
    /// [`crate::programme::Programme::to_shader`].
    ///
    /// # Errors
    /// If the programme has too many steps for a shader, or uses erosion.
    pub fn shader(&self, language: ShaderLanguage) -> Result<String, ShaderError> {
        let document = self.document();
        let base = &document.base;
        let frame = Frame { seed: document.seed, scale: base.scale, origin: base.origin };
        let range = [document.elevation.min, document.elevation.max];
        let text = base.programme.to_shader(language, &Ground { frame, amplitude: base.amplitude, datum: base.datum, range })?;
        // Names of layers are letters, digits and hyphens, so they cannot end a comment.
        let names: Vec<&str> = document.layers.iter().map(|layer| &*layer.name).collect();
        Ok(if names.is_empty() {
            text
        } else {
            format!("// The base of the world alone, without what lies above it: its layers ({}) are not part of this.\n{text}", names.join(", "))
        })
    }
}
