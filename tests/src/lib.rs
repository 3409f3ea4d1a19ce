//! What the integration tests share: test meshes, exact references, ray files.
