//! `--watch`: a page at an address of this machine that follows the run.
//!
//! [`LiveReport`] determines the content of the page; this module has the address, the connections, and data of the run besides its rows.

mod request;
mod server;
mod site;

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use crate::output::{Activity, LiveOutcome, LiveReport, NOT_CONSERVING};
use crate::script::{Class, Diagnostic, Event, Ink, Observer, Progress, Report};
use site::Site;

/// Number of random bytes of the secret in the address.
const SECRET: usize = 16;
/// Longest time for which the end of the process is delayed until readers have received it, and the period of checks.
const GRACE: [Duration; 2] = [Duration::from_millis(950), Duration::from_millis(5)];

/// The page of a running simulation.
pub struct LivePage {
    /// Report shown by the page.
    pub report: Arc<LiveReport>,
    site: Arc<Site>,
}

impl LivePage {
    /// Serves the page at a port (0 for any free one); `folder` is that of the results.
    ///
    /// # Errors
    /// The port is not available, or there are no random numbers.
    pub fn open(port: u16, folder: String) -> Result<Self, Box<Diagnostic>> {
        let refused = |cause: String| {
            let error = Diagnostic::error(Class::Script, "the run cannot be shown while it goes on").cause(cause);
            Box::new(error.hint("name another port with `--watch=PORT`, or take any that is free with `--watch`"))
        };
        let listener = server::open(port).map_err(|error| refused(format!("port {port} of this machine: {error}")))?;
        let port = listener.local_addr().map_err(|error| refused(error.to_string()))?.port();
        let mut bytes = [0; SECRET];
        getrandom::fill(&mut bytes).map_err(|error| refused(format!("the operating system provides no random numbers: {error}")))?;
        let secret = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        let report = Arc::new(LiveReport::new(folder));
        let site = Arc::new(Site::new(report.clone(), port, secret));
        server::serve(listener, site.clone()).map_err(|error| refused(format!("no thread could be started: {error}")))?;
        Ok(LivePage { report, site })
    }

    /// Address of the page.
    pub fn address(&self) -> String {
        self.site.address()
    }

    /// Shows the outcome of the run, and waits briefly until readers have received it.
    pub fn end(&self, report: &Report) {
        let (words, is_well) = match &report.error {
            None if report.is_conserving => ("completed".into(), true),
            None => (NOT_CONSERVING.into(), false),
            Some(error) if error.class == Class::Interrupted => ("interrupted".into(), false),
            Some(error) => (error.title.clone(), false),
        };
        self.report.end(LiveOutcome { words, is_well });
        let begun = Instant::now();
        while self.site.has_readers() && begun.elapsed() < GRACE[0] {
            thread::sleep(GRACE[1]);
        }
    }
}

/// Observer that updates a page, and passes all calls on to another observer.
pub struct LiveObserver {
    report: Arc<LiveReport>,
    next: Rc<dyn Observer>,
    doing: RefCell<Activity>,
}

impl LiveObserver {
    /// Returns an observer in front of `next`.
    pub fn new(report: Arc<LiveReport>, next: Rc<dyn Observer>) -> Self {
        LiveObserver { report, next, doing: RefCell::default() }
    }

    fn does(&self, doing: Activity) {
        if *self.doing.borrow() != doing {
            *self.doing.borrow_mut() = doing.clone();
            self.report.does(doing);
        }
    }
}

impl Observer for LiveObserver {
    fn print(&self, line: &str) {
        self.next.print(line);
    }

    fn passed(&self, line: &str) {
        self.next.passed(line);
    }

    fn warn(&self, warning: &Diagnostic) {
        let mut shown = warning.clone();
        // Scripts by file name, as in the report.
        if let Some(place) = &mut shown.place {
            place.source = place.source.rsplit(['/', '\\']).next().unwrap_or_default().into();
        }
        self.report.warn(shown.render(Ink::Plain));
        self.next.warn(warning);
    }

    fn advanced(&self, progress: &Progress) {
        self.does(Activity { what: None, until: progress.until });
        self.next.advanced(progress);
    }

    fn noticed(&self, event: &Event) {
        self.next.noticed(event);
    }

    fn began(&self, what: &str) {
        self.does(Activity { what: Some(what.into()), until: None });
        self.next.began(what);
    }

    fn ended(&self) {
        self.does(Activity::default());
        self.next.ended();
    }

    fn ink(&self) -> Ink {
        self.next.ink()
    }
}
