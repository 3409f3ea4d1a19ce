//! Both eyes' pictures for a display that has one.

use super::pictures::Writer;
use super::report::StereoReport;
use crate::cave::{Cave, Eye, Screen};
use crate::cli::output::failure::Failure;
use crate::cli::output::picture_files::metadata;
use crate::picture::Picture;
use crate::render::Frame;
use crate::show::overview::net;
use crate::show::overview::viewer::{self, ViewerCamera};
use crate::show::stereo::Stereo;

impl Writer<'_> {
    /// Writes the walls unfolded, and as `cameras`, one an eye, see them; none where
    /// one eye's are enough.
    ///
    /// # Errors
    /// A file that cannot be written, or a composite that cannot be made.
    pub(super) fn write_stereo(
        &self,
        frame: &Frame,
        cave: &Cave,
        cameras: &[ViewerCamera],
    ) -> Result<Option<StereoReport>, Failure> {
        let (
            Stereo::Sequential | Stereo::SideBySide | Stereo::TopBottom | Stereo::Anaglyph,
            [left, right],
        ) = (self.stereo, cameras)
        else {
            return Ok(None);
        };
        let mut images = Vec::new();
        let [of_left, of_right] = Eye::STEREO.map(|eye| seen_by(eye, frame, cave));
        let unfold = |seen: &[_]| net::unfold(seen).map_err(Failure::from_error);
        let nets = [unfold(&of_left)?, unfold(&of_right)?];
        self.write_pair("stereo-cave", &nets, &mut images)?;
        let look = |camera, seen: &[_]| viewer::render(camera, seen).map_err(Failure::from_error);
        let views = [look(left, &of_left)?, look(right, &of_right)?];
        self.write_pair("stereo-viewer", &views, &mut images)?;
        Ok(Some(StereoReport {
            format: self.stereo.name(),
            eye_order: Eye::STEREO.map(Eye::name),
            images,
        }))
    }

    /// Writes one pair, and notes the paths.
    fn write_pair(
        &self,
        name: &str,
        [left, right]: &[Picture; 2],
        paths: &mut Vec<String>,
    ) -> Result<(), Failure> {
        let shown = self.stereo.compose(left, right);
        for one in shown.map_err(Failure::from_error)? {
            let suffix = one.eye.map_or(String::new(), |eye| format!("-{eye}"));
            let path = self.folder.join(format!("{name}{suffix}.png"));
            let note = format!("{}, both eyes", self.title);
            let mut notes = metadata(note).to_vec();
            notes.extend(self.stereo.metadata(one.eye));
            one.picture
                .write_png(&path, &notes)
                .map_err(Failure::from_error)?;
            paths.push(path.display().to_string());
        }
        Ok(())
    }
}

fn seen_by<'f>(eye: Eye, frame: &'f Frame, cave: &'f Cave) -> Vec<(Screen<'f>, &'f Picture)> {
    let pictures = frame.pictures.iter().filter(|one| one.eye == eye);
    pictures
        .filter_map(|one| Some((cave.screens().nth(one.wall)?, &one.picture)))
        .collect()
}
