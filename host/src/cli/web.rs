//! `shisen web`: the page that shows Shisen in a browser.

use crate::cli::arguments::SceneName;
use crate::cli::prelude::*;

/// Serves a page that shows scenes in a browser, to this machine alone
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Port of 127.0.0.1; 0 takes a free one
    #[arg(long, value_name = "N", default_value_t = 8_760, value_parser = whole::<u16>(0..=65_535))]
    port: u16,
    /// A scene of your own, beside those of the page: a model, a TOML description or a baked scene
    /// of the compact layout
    #[arg(long, value_name = "FILE")]
    scene: Option<SceneName>,
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
    use std::io::{self, BufRead as _, BufReader, Read as _, Write as _};
    use std::net::{TcpListener, TcpStream};
    use std::sync::Arc;

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
        "stage.js": "text/javascript",
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

    /// The scene of `--scene`.
    struct Own {
        name: SceneName,
        bytes: Vec<u8>,
    }

    /// How long a browser may take to ask and to take what it asked for.
    const PATIENCE: Duration = Duration::from_secs(10);

    /// Most bytes of a request.
    const MOST_ASKED: u64 = 64 << 10;

    pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
        let own = arguments.scene.as_ref().map(Own::baked).transpose()?;
        let listener = TcpListener::bind(("127.0.0.1", arguments.port)).map_err(|reason| {
            let message = format!("port {} cannot be served: {reason}", arguments.port);
            Fault::new(message, "give another one with --port, or 0 for a free one")
        })?;
        let address = listener.local_addr().or_fail()?;
        let interrupt = Interrupt::watched();
        say(&format!("the page is http://{address}/ until Ctrl-C"));
        let own = Arc::new(own);
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let own = Arc::clone(&own);
                // Those who leave before they have it miss nothing.
                std::thread::spawn(move || answer(&stream, own.as_ref().as_ref()));
            }
        });
        while !interrupt.came() {
            std::thread::sleep(Duration::from_millis(100));
        }
        Ok(())
    }

    /// Answers one request of a browser. The connection ends with it.
    fn answer(mut stream: &TcpStream, own: Option<&Own>) -> io::Result<()> {
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let mut lines = BufReader::new(stream.take(MOST_ASKED)).lines();
        let asked = lines.next().transpose()?.unwrap_or_default();
        // A browser that has not been heard to its end sees its connection fail.
        while lines
            .next()
            .transpose()?
            .is_some_and(|line| !line.is_empty())
        {}
        let mut words = asked.split(' ');
        let (method, path) = (
            words.next().unwrap_or_default(),
            words.next().unwrap_or_default(),
        );
        let path = path.split(['?', '#']).next().unwrap_or_default();
        let path = match path.trim_start_matches('/') {
            "" => "index.html",
            path => path,
        };
        let found = Some(path).filter(|_| matches!(method, "GET" | "HEAD"));
        let (status, (kind, bytes)) = match found.and_then(|path| file(path, own)) {
            Some(found) => ("200 OK", found),
            None => ("404 Not Found", ("text/plain", b"no such file".into())),
        };
        write!(
            stream,
            "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\n\
             Connection: close\r\n\r\n",
            bytes.len()
        )?;
        if method != "HEAD" {
            stream.write_all(&bytes)?;
        }
        stream.flush()
    }

    /// Returns a file of the page and its type.
    fn file<'a>(path: &str, own: Option<&'a Own>) -> Option<(&'static str, Cow<'a, [u8]>)> {
        let page = FILES.iter().find(|(name, ..)| *name == path);
        match (path, own, page) {
            (OWN, Some(own), _) => Some(("application/octet-stream", own.bytes.as_slice().into())),
            ("scenes.json", Some(own), Some((_, kind, bytes))) => {
                // The own one first.
                let text = String::from_utf8_lossy(bytes);
                let text = text.replacen('[', &format!("[\n{},", own.entry()), 1);
                Some((kind, text.into_bytes().into()))
            }
            (.., page) => page.map(|(_, kind, bytes)| (*kind, (*bytes).into())),
        }
    }

    impl Own {
        /// Bakes a scene in the compact layout.
        fn baked(name: &SceneName) -> Result<Self, Failure> {
            let ticker = Ticker::start(format!("baking {name}"), false);
            let source = Source::load(name, &ModelArguments::default())?;
            let baked = source.baked(Layout::Compact, None, &ticker)?.baked;
            if baked.layout() != Layout::Compact {
                let message = format!("{name} was baked in the fast layout");
                let help = "a page takes the compact one: shisen bake SCENE --layout compact";
                return Err(Fault::new(message, help).into());
            }
            Ok(Self {
                name: name.clone(),
                bytes: baked.as_bytes().to_vec(),
            })
        }

        /// Returns its entry of `scenes.json`: its name, its file, and what a desk calls it.
        fn entry(&self) -> serde_json::Value {
            let text = self.name.to_string();
            let desk = Path::new(&text);
            serde_json::json!({
                "name": desk.file_stem().unwrap_or_default().to_string_lossy(),
                "file": OWN,
                "source": desk.file_name().unwrap_or_default().to_string_lossy(),
            })
        }
    }
}
