//! The real program, run as its users run it.

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::TcpStream,
    path::Path,
    process::{Child, Command, Output, Stdio},
    sync::{Arc, Mutex},
    thread::JoinHandle,
    time::Duration,
};

pub(crate) const TERRANE: &str = env!("CARGO_BIN_EXE_terrane");

/// A running server on a free port.
pub(crate) struct Server {
    pub child: Child,
    pub address: String,
    log: Arc<Mutex<Vec<String>>>,
    reader: Option<JoinHandle<()>>,
}

impl Server {
    pub(crate) fn start(data: &Path) -> Self {
        Self::start_with(data, &[])
    }

    /// With variables of its environment.
    pub(crate) fn start_with(data: &Path, variables: &[(&str, &str)]) -> Self {
        let variables = variables.iter().copied();
        let mut child =
            Command::new(TERRANE).args(["serve", "--listen", "127.0.0.1:0", "--data"]).arg(data).envs(variables).stderr(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let log = Arc::new(Mutex::new(Vec::new()));
        let address = loop {
            let line = lines.next().expect("the server ended before it listened").unwrap();
            log.lock().unwrap().push(line.clone());
            if let Some((_, address)) = line.split_once("listening on http://") {
                break address.to_owned();
            }
        };
        let rest = Arc::clone(&log);
        let reader = std::thread::spawn(move || lines.map_while(Result::ok).for_each(|line| rest.lock().unwrap().push(line)));
        Self { child, address, log, reader: Some(reader) }
    }

    /// Status and body of a request on a connection of its own.
    pub(crate) fn request(&self, method: &str, path: &str, body: &str) -> std::io::Result<(u16, Vec<u8>)> {
        self.request_with(method, path, &format!("Host: {}", self.address), body)
    }

    /// With headers of its own, Host among them.
    pub(crate) fn request_with(&self, method: &str, path: &str, headers: &str, body: impl AsRef<[u8]>) -> std::io::Result<(u16, Vec<u8>)> {
        let (body, mut stream) = (body.as_ref(), TcpStream::connect(&self.address)?);
        stream.set_read_timeout(Some(Duration::from_secs(20)))?;
        let head = format!("{method} {path} HTTP/1.1\r\n{headers}\r\nConnection: close\r\nContent-Length: {}\r\n\r\n", body.len());
        stream.write_all(&[head.as_bytes(), body].concat())?;
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer)?;
        let end = answer.windows(4).position(|window| window == b"\r\n\r\n").ok_or(std::io::ErrorKind::UnexpectedEof)?;
        let status = std::str::from_utf8(&answer[9..12]).ok().and_then(|status| status.parse().ok()).ok_or(std::io::ErrorKind::InvalidData)?;
        Ok((status, answer.split_off(end + 4)))
    }

    pub(crate) fn get(&self, path: &str) -> Vec<u8> {
        let (status, body) = self.request("GET", path, "").unwrap();
        assert_eq!(status, 200, "{path}: {}", String::from_utf8_lossy(&body));
        body
    }

    /// SIGTERM; the exit code and the log.
    #[cfg(unix)]
    pub(crate) fn stop(mut self) -> (Option<i32>, Vec<String>) {
        let asked = Command::new("kill").arg(self.child.id().to_string()).status().unwrap();
        assert!(asked.success());
        let code = self.child.wait().unwrap().code();
        self.reader.take().unwrap().join().unwrap();
        let log = self.log.lock().unwrap().clone();
        (code, log)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

pub(crate) fn run(arguments: &[&str], folder: &Path) -> Output {
    Command::new(TERRANE).env_clear().args(arguments).current_dir(folder).output().unwrap()
}

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}
