//! `shisen web`: the page that shows Shisen in a browser.

use crate::cli::prelude::*;

/// Serves a page that shows scenes in a browser, to this machine alone
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Port of 127.0.0.1; 0 takes a free one
    #[arg(long, value_name = "N", default_value_t = 8_760, value_parser = whole::<u16>(0..))]
    port: u16,
    /// A scene of your own, beside those of the page: a model, a TOML description or a baked scene
    /// of the compact layout
    #[arg(long, value_name = "FILE")]
    scene: Option<PathBuf>,
}

#[cfg(not(feature = "web"))]
pub(super) fn run(_: &Arguments) -> Result<(), Failure> {
    let help = "run host/web/build in Shisen's folder: it makes the page, and a shisen that has it";
    Err(Fault::new("this program was built without the page", help).into())
}

#[cfg(feature = "web")]
pub(super) use serving::run;

#[cfg(feature = "web")]
mod serving {
    use super::Arguments;
    use crate::bake::Layout;
    use crate::cli::arguments::source::Source;
    use crate::cli::arguments::{ModelArguments, SceneName};
    use crate::cli::output::progress::Ticker;
    use crate::cli::prelude::*;
    use crate::cli::tracker::Interrupt;
    use std::borrow::Cow;
    use tiny_http::{Header, Method, Response, Server};

    /// Files of the page, each with its type.
    macro_rules! files {
        ($($name:literal: $kind:literal,)+) => {
            &[$(($name, $kind, include_bytes!(concat!(env!("SHISEN_PAGE"), "/", $name)))),+]
        };
    }

    const FILES: &[(&str, &str, &[u8])] = files!(
        "index.html": "text/html; charset=utf-8",
        "page.css": "text/css",
        "page.js": "text/javascript",
        "frame.js": "text/javascript",
        "fovea.js": "text/javascript",
        "record.js": "text/javascript",
        "worker.js": "text/javascript",
        "shisen.wasm": "application/wasm",
        "shisen-simd.wasm": "application/wasm",
        "scenes.json": "application/json",
        "animal.shisen": "application/octet-stream",
        "animal-levels.shisen": "application/octet-stream",
        "gallery.shisen": "application/octet-stream",
        "prism.shisen": "application/octet-stream",
        "dome.shisen": "application/octet-stream",
    );

    /// The path of the scene of `--scene`.
    const OWN: &str = "own.shisen";

    pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
        let own = arguments.scene.as_deref().map(baked).transpose()?;
        let address = ("127.0.0.1", arguments.port);
        let server = Server::http(address).map_err(|reason| {
            let message = format!("port {} cannot be served: {reason}", arguments.port);
            Fault::new(message, "give another one with --port, or 0 for a free one")
        })?;
        let interrupt = Interrupt::watched();
        say(&format!(
            "the page is http://{}/ until Ctrl-C",
            server.server_addr()
        ));
        while !interrupt.came() {
            let asked = server.recv_timeout(Duration::from_millis(200)).or_fail()?;
            let Some(request) = asked else {
                continue;
            };
            let path = request.url().split(['?', '#']).next().unwrap_or_default();
            let path = match path.trim_start_matches('/') {
                "" => "index.html",
                path => path,
            };
            let found = match *request.method() {
                Method::Get | Method::Head => file(path, own.as_deref()),
                _ => None,
            };
            // Those who leave before they have it miss nothing.
            let _ = match found {
                Some((kind, bytes)) => {
                    let kind = Header::from_bytes("Content-Type", kind);
                    let mut response = Response::from_data(bytes.into_owned());
                    if let Ok(kind) = kind {
                        response.add_header(kind);
                    }
                    request.respond(response)
                }
                None => {
                    request.respond(Response::from_string("no such file").with_status_code(404))
                }
            };
        }
        Ok(())
    }

    /// Returns a file of the page and its type.
    fn file<'a>(path: &str, own: Option<&'a [u8]>) -> Option<(&'static str, Cow<'a, [u8]>)> {
        let (_, kind, bytes) = FILES
            .iter()
            .find(|(name, ..)| *name == path)
            .copied()
            .or_else(|| {
                own.filter(|_| path == OWN)
                    .map(|_| (OWN, "application/octet-stream", &[][..]))
            })?;
        Some(match (path, own) {
            (OWN, Some(own)) => (kind, Cow::Borrowed(own)),
            ("scenes.json", Some(_)) => {
                // The own one first.
                let text = String::from_utf8_lossy(bytes);
                let entry = format!("[\n{{\"name\":\"own\",\"file\":\"{OWN}\"}},");
                (kind, Cow::Owned(text.replacen('[', &entry, 1).into_bytes()))
            }
            _ => (kind, Cow::Owned(bytes.to_vec())),
        })
    }

    /// Returns a scene in the compact layout.
    fn baked(path: &Path) -> Result<Vec<u8>, Failure> {
        let name = SceneName::File(path.to_owned());
        let ticker = Ticker::start(format!("baking {}", path.display()), false);
        let source = Source::load(&name, &ModelArguments::default())?;
        let baked = source.baked(Layout::Compact, None, &ticker)?.baked;
        if baked.layout() != Layout::Compact {
            let message = format!("{} was baked in the fast layout", path.display());
            let help = "a page takes the compact one: shisen bake SCENE --layout compact";
            return Err(Fault::new(message, help).into());
        }
        Ok(baked.as_bytes().to_vec())
    }
}
