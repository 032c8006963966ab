//! `--watch`: the page that follows a run is available only with its address, shows the content of the files, and does not affect the run,
//! whatever is requested.

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

#[path = "../common/browser.rs"]
mod browser;
#[path = "../common/program.rs"]
mod program;
#[path = "../common/run_files.rs"]
mod run_files;

use browser::Browser;
use program::{conserva, folder};
use run_files::assert_same;

/// A ball that bounces on a plane until a time.
const BOUNCE: &str = r#"
let end = param("end", 1.0);
let cells = param("cells", 2);
let rubber = neo_hookean(#{ youngs_modulus: 1e3, poisson_ratio: 0.3, density: 1.0 });
let drop = model("drop");
let ball = drop.add_body("ball", disk(#{ radius: 0.5, cells: [cells, 4 * cells], center: [0.0, 0.6] }), rubber);
drop.gravity([0.0, -10.0]);
drop.add_contact("ground", #{ secondary: ball.boundary("outer"), primary: rigid_plane(#{ point: [0.0, 0.0], normal: [0.0, 1.0] }) });
let sim = simulate(drop, #{ integrator: energy_momentum(), dt: 0.005, fields_every: 0.5 });
let start = sim.save();
sim.run_to(0.1);
sim.restore(start);
let color = param("color", "red");
sim.run_to(end);
"#;

/// A run that is watched.
struct Watched {
    process: Child,
    address: String,
    home: PathBuf,
}

impl Watched {
    /// Starts a run in a folder with a script, and waits for its address.
    fn start(home: &Path, arguments: &[&str]) -> Watched {
        let mut process = conserva(home, arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let mut messages = BufReader::new(process.stderr.take().unwrap());
        let mut line = String::new();
        while !line.contains("http://") {
            line.clear();
            assert!(messages.read_line(&mut line).unwrap() > 0, "it tells its address");
        }
        let address = line[line.find("http://").unwrap()..].trim().trim_end_matches("\"}").to_string();
        thread::spawn(move || std::io::copy(&mut messages, &mut std::io::sink()));
        Watched { process, address, home: home.into() }
    }

    /// Starts a run without an end.
    fn endless(name: &str) -> Watched {
        Watched::start(&folder(name, BOUNCE), &["run", "main.rhai", "--out", "out", "--quiet", "--watch", "--set", "end=1e6"])
    }

    fn host(&self) -> &str {
        self.address["http://".len()..].split('/').next().unwrap()
    }

    fn path(&self) -> &str {
        &self.address["http://".len() + self.host().len()..]
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.host()).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        stream
    }

    /// Status and content of the answer to raw bytes.
    fn answer(&self, request: &str) -> (u16, String) {
        let mut stream = self.connect();
        let _ = stream.write_all(request.as_bytes());
        read(stream)
    }

    /// Content at a path below the secret.
    fn get(&self, path: &str) -> (u16, String) {
        self.answer(&format!("GET {}{path} HTTP/1.1\r\nHost: {}\r\n\r\n", self.path(), self.host()))
    }

    /// Changes since a change number.
    fn news(&self, reader: u32, since: u64) -> Option<Value> {
        let mut stream = TcpStream::connect(self.host()).ok()?;
        let path = format!("{}data?since={since}&simulation=0&reader={reader}", self.path());
        stream.write_all(format!("GET {path} HTTP/1.1\r\nHost: {}\r\n\r\n", self.host()).as_bytes()).ok()?;
        let (status, content) = read(stream);
        assert_eq!(status, 200);
        Some(serde_json::from_str(&content).unwrap())
    }

    /// Waits until there is a simulation.
    fn wait(&self) {
        while self.news(1, 0).unwrap()["state"]["simulations"] == json!([]) {
            thread::sleep(Duration::from_millis(10));
        }
    }

    fn signal(&self, name: &str) {
        let _ = Command::new("kill").args([name, &self.process.id().to_string()]).stderr(Stdio::null()).status();
    }

    /// Interrupts the run; returns its exit code.
    fn stop(mut self) -> Option<i32> {
        self.signal("-INT");
        self.process.wait().unwrap().code()
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn read(mut stream: TcpStream) -> (u16, String) {
    let mut bytes = Vec::new();
    let _ = stream.read_to_end(&mut bytes);
    let text = String::from_utf8_lossy(&bytes);
    let status = text.split(' ').nth(1).and_then(|status| status.parse().ok()).unwrap_or(0);
    (status, text.split_once("\r\n\r\n").map(|(_, content)| content.to_string()).unwrap_or_default())
}

/// Lock that serializes tests: a process waits a limited time at its end for its readers, which those of other tests would use up.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

#[test]
fn nobody_else_gets_an_answer() {
    let _alone = alone();
    let run = Watched::endless("refused");
    run.wait();
    let (host, path) = (run.host().to_string(), run.path().to_string());
    let ask = |method: &str, path: &str, host: &str| run.answer(&format!("{method} {path} HTTP/1.1\r\nHost: {host}\r\n\r\n"));
    assert!(path.len() >= 34, "a secret of 128 bits: {path}");
    assert_eq!(ask("GET", &path, &host).0, 200);
    assert_eq!(ask("GET", &path, &host.replace("127.0.0.1", "localhost")).0, 200);
    assert_eq!(ask("HEAD", &path, &host), (200, String::new()));
    for other in ["evil.example", "127.0.0.1", "localhost", "127.0.0.1:1", "0.0.0.0", ""] {
        assert_eq!(ask("GET", &path, other).0, 403, "{other}");
    }
    let wrong = path.replace(&path[1..2], if &path[1..2] == "0" { "1" } else { "0" });
    for other in ["/", "/favicon.ico", "/data", &wrong, &format!("{path}../"), &format!("{path}report.html"), &format!("{path}%2e%2e/")] {
        let (status, content) = ask("GET", other, &host);
        assert!(status == 404 && content.len() < 100, "{other}: {status} {content}");
    }
    for method in ["POST", "PUT", "DELETE", "OPTIONS", "PATCH", "TRACE"] {
        assert_eq!(ask(method, &path, &host).0, 405, "{method}");
    }
    assert_eq!(run.answer("GET / HTTP/1.1\r\n\r\n").0, 400, "no host");
    assert_eq!(run.answer("nonsense\r\n\r\n").0, 400);
    assert_eq!(run.answer("\u{1}\u{2}\r\n\r\n").0, 400);
    // Not reachable from other machines: the server listens on the loopback address.
    let listening = fs::read_to_string("/proc/net/tcp").unwrap_or_default();
    let port = format!(":{:04X} ", host.split(':').next_back().unwrap().parse::<u16>().unwrap());
    assert!(listening.lines().filter(|line| line.contains(" 0A ") && line.contains(&port)).all(|line| line.contains("0100007F:")));
    // Headers of the answer.
    let mut stream = run.connect();
    stream.write_all(format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes()).unwrap();
    let mut bytes = Vec::new();
    stream.read_to_end(&mut bytes).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let head = text.split("\r\n\r\n").next().unwrap();
    for line in ["Cache-Control: no-store", "X-Content-Type-Options: nosniff", "Referrer-Policy: no-referrer", "connect-src 'self'"] {
        assert!(head.contains(line), "{line}: {head}");
    }
    assert!(!head.contains("Access-Control"), "no page from elsewhere may read it");
    assert_eq!(run.stop(), Some(130));
}

#[test]
fn who_is_slow_or_asks_too_much_is_left_behind() {
    let _alone = alone();
    let run = Watched::endless("slow");
    run.wait();
    let request = format!("GET {} HTTP/1.1\r\nHost: {}\r\n\r\n", run.path(), run.host());
    // Half a request, then one byte after the other, then nothing.
    let mut half = run.connect();
    half.write_all(&request.as_bytes()[..20]).unwrap();
    let mut drip = run.connect();
    let begun = Instant::now();
    assert_eq!(run.answer(&format!("GET /{} HTTP/1.1\r\n", "x".repeat(1 << 20))).0, 431);
    assert_eq!(run.answer(&format!("GET / HTTP/1.1\r\n{}\r\n", "a: b\r\n".repeat(1000))).0, 431);
    // A client that does not read.
    let mut deaf = run.connect();
    deaf.write_all(request.as_bytes()).unwrap();
    assert_eq!(run.get("").0, 200);
    assert!(begun.elapsed() < Duration::from_secs(5), "the others do not wait");
    let dripping = thread::spawn(move || {
        for _ in 0..100 {
            if drip.write_all(b"G").is_err() {
                break;
            }
            thread::sleep(Duration::from_millis(100));
        }
        read(drip).0
    });
    assert_eq!(read(half).0, 408);
    assert!([0, 400, 408].contains(&dripping.join().unwrap()));
    assert!(begun.elapsed() < Duration::from_secs(30));
    assert_eq!(run.get("").0, 200);
    drop(deaf);
    // More connections than the limit: some are refused, and all are served after these have gone.
    let idle: Vec<TcpStream> = (0..150).map(|_| run.connect()).collect();
    thread::sleep(Duration::from_millis(300));
    assert!([503, 0].contains(&run.get("").0));
    drop(idle);
    let begun = Instant::now();
    while run.get("").0 != 200 {
        assert!(begun.elapsed() < Duration::from_secs(20));
        thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(run.stop(), Some(130));
}

#[test]
fn a_hundred_readers_change_nothing() {
    let _alone = alone();
    let home = folder("crowd", BOUNCE);
    let quiet = |arguments: &[&str]| conserva(&home, arguments).output().unwrap().status.code();
    assert_eq!(quiet(&["run", "main.rhai", "--out", "alone", "--quiet", "--set", "end=10", "--set", "cells=8"]), Some(0));
    let mut run =
        Watched::start(&home, &["run", "main.rhai", "--out", "watched", "--quiet", "--watch", "--set", "end=10", "--set", "cells=8"]);
    run.wait();
    let _slow = run.connect();
    let mut streams: Vec<TcpStream> = (0..100).map(|_| run.connect()).collect();
    let request = format!("GET {} HTTP/1.1\r\nHost: {}\r\n\r\n", run.path(), run.host());
    streams.iter_mut().for_each(|stream| stream.write_all(request.as_bytes()).unwrap());
    for stream in streams {
        let (status, content) = read(stream);
        assert!(status == 200 && content.ends_with("</html>\n"));
    }
    assert_eq!(run.process.wait().unwrap().code(), Some(0));
    assert_same(&home.join("alone"), &home.join("watched"), "watched");
}

fn unpacked(packed: &Value) -> Vec<u8> {
    let mut bytes = Vec::new();
    let packed = STANDARD.decode(packed.as_str().unwrap()).unwrap();
    flate2::read::DeflateDecoder::new(&*packed).read_to_end(&mut bytes).unwrap();
    bytes
}

/// Reader with the protocol of the page: rows with the number of the change in which they came.
#[derive(Default)]
struct Reader {
    change: u64,
    rows: BTreeMap<u64, (usize, Vec<f64>)>,
    stills: BTreeMap<u64, (f64, usize)>,
    count: usize,
}

impl Reader {
    fn take(&mut self, news: &Value) {
        self.change = news["change"].as_u64().unwrap();
        let whole = |list: &Value| list.as_array().unwrap().iter().map(|number| number.as_u64().unwrap()).collect::<Vec<_>>();
        let (rows, stills) = (&news["rows"], &news["stills"]);
        if let Value::Array(_) = rows["left"] {
            let left = whole(&rows["left"]);
            self.rows.retain(|number, _| left.contains(number));
        }
        let (numbers, places) = (whole(&rows["numbers"]), whole(&rows["rows"]));
        let values: Vec<f64> = unpacked(&rows["values"]).chunks(8).map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap())).collect();
        for (k, (number, place)) in numbers.iter().zip(&places).enumerate() {
            let row = values.iter().skip(k).step_by(numbers.len()).copied().collect();
            self.rows.insert(*number, (*place as usize, row));
        }
        self.count = rows["count"].as_u64().unwrap() as usize;
        if stills.is_null() {
            return;
        }
        if let Value::Array(_) = stills["left"] {
            let left = whole(&stills["left"]);
            self.stills.retain(|number, _| left.contains(number));
        }
        for (number, still) in whole(&stills["numbers"]).iter().zip(stills["list"].as_array().unwrap()) {
            self.stills.insert(*number, (still["time"].as_f64().unwrap(), still["row"].as_u64().unwrap() as usize));
        }
        assert_eq!(unpacked(&stills["bytes"]).is_empty(), stills["list"] == json!([]));
    }
}

#[test]
fn readers_have_the_rows_of_the_history_when_it_has_ended() {
    let _alone = alone();
    // More rows than a page shows, discarded steps, removed stills.
    let home = folder("rows", BOUNCE);
    let mut run = Watched::start(&home, &["run", "main.rhai", "--out", "out", "--quiet", "--watch", "--set", "end=25", "--set", "cells=3"]);
    run.wait();
    // The second reader requests rarely.
    let mut readers = [Reader::default(), Reader::default()];
    let mut rounds = 0;
    let outcome = loop {
        let news = run.news(1, readers[0].change).expect("it waits for a reader at the end");
        readers[0].take(&news);
        let is_over = news["state"]["over"] == json!(true);
        if rounds % 10 == 0 || is_over {
            readers[1].take(&run.news(2, readers[1].change).expect("it goes on for a moment"));
        }
        if is_over {
            break news["state"].clone();
        }
        rounds += 1;
        thread::sleep(Duration::from_millis(20));
    };
    assert_eq!(run.process.wait().unwrap().code(), Some(0));
    assert!(rounds > 5, "it was watched for a while");
    assert_eq!((&outcome["outcome"], &outcome["well"], &outcome["folder"]), (&json!("completed"), &json!(true), &json!("out")));
    let text = fs::read_to_string(run.home.join("out/history.csv")).unwrap();
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|line| line.split(',').map(|field| field.parse().unwrap_or(f64::NAN)).collect()).collect();
    assert!(rows.len() > 4500, "{}", rows.len());
    assert!(readers[0].rows.keys().eq(readers[1].rows.keys()) && readers[0].stills == readers[1].stills);
    for reader in &readers {
        assert_eq!(reader.count, rows.len());
        let places: Vec<usize> = reader.rows.values().map(|(place, _)| *place).collect();
        assert!(places.windows(2).all(|pair| pair[0] < pair[1]) && places[0] == 0 && *places.last().unwrap() == rows.len() - 1);
        assert!((500..=4000).contains(&places.len()), "{}", places.len());
        for (place, values) in reader.rows.values() {
            let same = values.iter().zip(&rows[*place]).all(|(a, b)| a == b || a.is_nan() && b.is_nan());
            assert!(same && values.len() == rows[*place].len(), "row {place}");
        }
        assert!((40..=161).contains(&reader.stills.len()));
        // This JSON reader rounds the last bit.
        assert!(
            reader
                .stills
                .values()
                .all(|(time, row)| (time - rows[*row][1]).abs() < 1e-12 && reader.rows.values().any(|(place, _)| place == row))
        );
    }
}

#[test]
fn ports_logs_and_resumed_runs() {
    let _alone = alone();
    let home = folder("ports", BOUNCE);
    let run = Watched::start(&home, &["run", "main.rhai", "--out", "out", "--log", "json", "--watch", "--set", "end=1e6"]);
    run.wait();
    assert_eq!(run.get("").0, 200);
    let port = run.host().split(':').next_back().unwrap().to_string();
    let second = conserva(&home, &["run", "main.rhai", "--out", "second", &format!("--watch={port}")]).output().unwrap();
    let message = program::stderr(&second);
    assert_eq!(second.status.code(), Some(2));
    assert!(message.contains(&format!("port {port}")) && message.contains("--watch=PORT"), "{message}");
    let odd = conserva(&home, &["run", "main.rhai", "--watch=70000"]).output().unwrap();
    assert_eq!(odd.status.code(), Some(2));
    thread::sleep(Duration::from_millis(200));
    assert_eq!(run.stop(), Some(130));
    let run = Watched::start(&home, &["resume", "out", "--quiet", &format!("--watch={port}")]);
    assert!(run.address.contains(&format!(":{port}/")));
    run.wait();
    let mut reader = Reader::default();
    while reader.count < 100 || reader.stills.len() < 20 {
        reader.take(&run.news(1, reader.change).unwrap());
    }
    assert_eq!(run.stop(), Some(130));
    // The address is in the log and on standard error.
    let run =
        Watched::start(&home, &["run", "main.rhai", "--out", "third", "--log", "json:log.jsonl", "--quiet", "--watch", "--set", "end=1e6"]);
    run.wait();
    let line = fs::read_to_string(home.join("log.jsonl")).unwrap().lines().nth(1).unwrap().to_string();
    assert_eq!(serde_json::from_str::<Value>(&line).unwrap(), json!({ "event": "watch", "address": run.address }));
    assert_eq!(run.stop(), Some(130));
}

#[test]
fn the_page_follows_and_tells_the_end() {
    let _alone = alone();
    let home = folder("browser", BOUNCE);
    let Some(mut page) = Browser::start(&home.join("profile")) else {
        return eprintln!("SKIPPED: no Chromium on this machine, so nobody has looked at the page that follows a run");
    };
    let run = Watched::start(&home, &["run", "main.rhai", "--out", "out", "--quiet", "--watch", "--set", "end=1e6"]);
    run.wait();
    page.allowed = run.address.clone();
    page.visit(&run.address);
    page.wait_for("document.documentElement.dataset.following === 'true'");
    let seen = |page: &mut Browser| page.evaluate("conserva.data.row_count").as_u64().unwrap();
    let before = seen(&mut page);
    page.wait_for(&format!("conserva.data.row_count > {before} && conserva.still === conserva.data.stills.length - 1"));
    page.wait_for("document.getElementById('outcome').textContent.startsWith('running, t = ')");
    page.wait_for("conserva.data.parameters.color === 'red'");
    // A reader at an earlier time stays there while new stills arrive.
    page.evaluate("(() => { const m = document.getElementById('moment'); m.value = 0; m.dispatchEvent(new Event('input')); })()");
    let (time, before) = (page.evaluate("conserva.data.stills[conserva.still].time"), seen(&mut page));
    page.wait_for(&format!("conserva.data.row_count > {before}"));
    assert_eq!(page.evaluate("document.getElementById('newest').checked"), json!(false));
    assert_eq!(page.evaluate("conserva.data.stills[conserva.still].time"), time);
    page.evaluate("document.getElementById('newest').click()");
    page.settle();
    assert_eq!(page.evaluate("conserva.still === conserva.data.stills.length - 1"), json!(true));
    assert_eq!(page.complaints, Vec::<Value>::new());
    // The page receives the end of the run, and then has the content of the report.
    assert_eq!(run.stop(), Some(130));
    page.wait_for("document.documentElement.dataset.following === 'over'");
    assert_eq!(page.evaluate("document.getElementById('outcome').textContent"), json!("interrupted"));
    assert!(page.evaluate("document.getElementById('following').textContent").as_str().unwrap().contains("report.html in out"));
    let rows = fs::read_to_string(home.join("out/history.csv")).unwrap().lines().count() as u64 - 1;
    assert_eq!(seen(&mut page), rows);
    let last = page.evaluate("[...conserva.columns.values()].map((values) => values[values.length - 1])");
    page.allowed = "file:".into();
    page.open(&home.join("out/report.html"));
    assert_eq!(page.evaluate("[...conserva.columns.values()].map((values) => values[values.length - 1])"), last);
    assert_eq!(page.evaluate("conserva.data.outcome"), json!("interrupted"));
    assert_eq!(page.complaints, Vec::<Value>::new());
}
