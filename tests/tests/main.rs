//! What crosses the crates, in one program: each would else compile the tracer
//! again, and take as long to link as to run.

mod blob_fuzz;
mod brute_force;
mod capture;
mod command;
mod command_faults;
mod determinism;
mod dispersion;
mod dome;
mod dome_command;
mod dome_pictures;
mod dome_screen;
mod effects;
mod exact;
mod fill;
mod frame_job;
mod gaze;
mod gaze_command;
mod hard_cases;
mod levels;
mod live;
mod lod;
mod optics;
mod paper_rays;
mod public_functions;
mod readme;
mod reprojection;
mod scene_fuzz;
mod soft_light;
mod spectrum;
mod textures;
mod tracker_calibration;
mod tracker_command;
mod tracker_fuzz;
mod tradeoff_command;
mod watertight;
