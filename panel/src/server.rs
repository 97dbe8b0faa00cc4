//! The server: the page, and a WebSocket for each window.
//!
//! Everything that waits is bounded: orders for the session, replies to a window, frames to tell. A window that does not read is closed.

use std::sync::Arc;
use std::sync::mpsc::{SyncSender, TrySendError};
use std::time::Duration;

use axum::Router;
use axum::body::Bytes;
use axum::extract::State;
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::http::{HeaderMap, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use tokio::net::TcpListener;
use tokio::sync::broadcast;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::mpsc;
use tokio::time::{Instant, MissedTickBehavior, interval, timeout};

use crate::desk::Desk;
use crate::message::{Answer, Event, Order, Outcome, Request};
use crate::session::{Outlet, Ticket, json};
use crate::{assets, origin};

/// Windows at once.
const WINDOWS: usize = 32;

/// The longest message of a window, in bytes: the DCF of a device with thousands of entries.
const LONGEST_MESSAGE: usize = 8 * 1024 * 1024;

/// Replies that wait for a window.
const REPLIES: usize = 64;

/// How long a window may leave a message unread, and how long nothing may come from it: the cable may be out.
const PATIENCE: Duration = Duration::from_secs(5);

/// How often a window is asked whether it is still there; a browser answers by itself, also for a page in the background.
const PING: Duration = Duration::from_secs(1);

/// From a look at who may write to the next.
const GLANCE: Duration = Duration::from_millis(250);

/// The page loads nothing from elsewhere, and nobody else may frame it.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; \
                      base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// What all windows share.
#[derive(Debug)]
pub struct Shared {
    /// Who may write, and what may not wait.
    pub desk: Arc<Desk>,
    /// To the session.
    pub tickets: SyncSender<Ticket>,
    /// From the session.
    pub outlet: Outlet,
    /// Nothing is written at all.
    pub read_only: bool,
    /// Where a person has told it to listen.
    pub listen: String,
    /// What a window must know.
    pub token: Option<String>,
}

/// Serves until the runtime ends.
///
/// # Errors
/// When nothing can be served any more.
pub async fn serve(listener: TcpListener, shared: Arc<Shared>) -> std::io::Result<()> {
    let router = Router::new()
        .route("/ws", get(window))
        .route("/token", get(token))
        .fallback(get(file))
        .with_state(shared);
    axum::serve(listener, router).await
}

async fn file(uri: Uri) -> Response {
    let headers = |kind: &'static str| {
        [
            (header::CONTENT_TYPE, kind),
            (header::CONTENT_SECURITY_POLICY, POLICY),
            (header::CACHE_CONTROL, "no-cache"),
            (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
            (header::REFERRER_POLICY, "no-referrer"),
        ]
    };
    match assets::find(uri.path()) {
        Some(asset) => (headers(asset.kind), asset.bytes).into_response(),
        None => StatusCode::NOT_FOUND.into_response(),
    }
}

/// Whether an address has the token; a socket that was refused does not tell a page why.
async fn token(State(shared): State<Arc<Shared>>, uri: Uri) -> StatusCode {
    match &shared.token {
        Some(token) if !origin::has_token(uri.query(), token) => StatusCode::UNAUTHORIZED,
        _ => StatusCode::NO_CONTENT,
    }
}

async fn window(
    State(shared): State<Arc<Shared>>,
    headers: HeaderMap,
    uri: Uri,
    upgrade: WebSocketUpgrade,
) -> Response {
    let text = |name| headers.get(name).and_then(|value| value.to_str().ok());
    if !origin::is_own(text(header::ORIGIN), text(header::HOST), &shared.listen) {
        return (StatusCode::FORBIDDEN, "not a page of this panel").into_response();
    }
    if let Some(token) = &shared.token
        && !origin::has_token(uri.query(), token)
    {
        return (StatusCode::UNAUTHORIZED, "the token is missing or wrong").into_response();
    }
    if shared.desk.open_windows() >= WINDOWS {
        return (StatusCode::SERVICE_UNAVAILABLE, "too many windows").into_response();
    }
    upgrade
        .max_message_size(LONGEST_MESSAGE)
        .on_upgrade(|socket| async move {
            let window = Window::open(shared);
            window.run(socket).await;
        })
}

/// A window that is open; it is closed when this is dropped.
struct Window {
    shared: Arc<Shared>,
    number: u64,
    replies: mpsc::Sender<Event>,
    from_session: mpsc::Receiver<Event>,
    /// While it wants to see frames.
    frames: Option<broadcast::Receiver<Arc<str>>>,
    /// While it wants to see what transmit PDOs bring.
    live: Option<broadcast::Receiver<Arc<str>>>,
}

impl Drop for Window {
    fn drop(&mut self) {
        self.shared.desk.close(self.number);
    }
}

impl Window {
    fn open(shared: Arc<Shared>) -> Self {
        let (replies, from_session) = mpsc::channel(REPLIES);
        Self {
            number: shared.desk.open(),
            shared,
            replies,
            from_session,
            frames: None,
            live: None,
        }
    }

    async fn run(mut self, mut socket: WebSocket) {
        let hello = Event::Hello {
            window: self.number,
            read_only: self.shared.read_only,
            version: env!("CARGO_PKG_VERSION"),
        };
        let mut states = self.shared.outlet.states.subscribe();
        states.mark_changed();
        let mut writer = None;
        if !send(&mut socket, &json(&hello)).await {
            return;
        }
        let mut glance = interval(GLANCE);
        glance.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut presence = Presence::new(Instant::now());
        loop {
            let now = Some(self.shared.desk.writer());
            if writer != now {
                writer = now;
                let event = Event::Writer {
                    window: now.flatten(),
                };
                if !send(&mut socket, &json(&event)).await {
                    return;
                }
            }
            let text = tokio::select! {
                // What a person does comes first.
                biased;
                message = socket.recv() => {
                    presence.heard(Instant::now());
                    match message {
                        Some(Ok(Message::Text(text))) => {
                            if !self.hear(&text) {
                                return;
                            }
                            continue;
                        }
                        Some(Ok(Message::Close(_)) | Err(_)) | None => return,
                        Some(Ok(_)) => continue,
                    }
                },
                now = glance.tick() => match presence.at(now) {
                    Present::Gone => return,
                    Present::Asked => {
                        if !deliver(&mut socket, Message::Ping(Bytes::new())).await {
                            return;
                        }
                        continue;
                    }
                    // Another window may have taken control.
                    Present::Yes => continue,
                },
                Some(reply) = self.from_session.recv() => json(&reply),
                changed = states.changed() => match changed {
                    Ok(()) => states.borrow_and_update().clone(),
                    Err(_) => return,
                },
                frames = next(&mut self.frames) => frames,
                values = next(&mut self.live) => values,
            };
            if !send(&mut socket, &text).await {
                return;
            }
        }
    }

    /// An order of a person. Returns false for one that cannot be understood: that is no page of ours.
    fn hear(&mut self, text: &str) -> bool {
        let Ok(Request { id, order }) = serde_json::from_str(text) else {
            return false;
        };
        let desk = &self.shared.desk;
        let is_writer = desk.writer() == Some(self.number);
        match order {
            Order::Stop => {
                desk.stop();
                self.reply(id, Outcome::Done(Answer::Text("stop".to_owned())));
            }
            Order::Release if is_writer => desk.release(),
            Order::Beat if is_writer => desk.beat(),
            Order::Release | Order::Beat => {}
            Order::Take => {
                desk.take(self.number);
                self.reply(id, Outcome::Done(Answer::Text(String::new())));
            }
            Order::Frames { on } => {
                self.frames = on.then(|| self.shared.outlet.frames.subscribe());
                self.reply(id, Outcome::Done(Answer::Text(String::new())));
            }
            Order::Live { on } => {
                self.live = on.then(|| self.shared.outlet.live.subscribe());
                self.reply(id, Outcome::Done(Answer::Text(String::new())));
            }
            order => self.order(id, order),
        }
        true
    }

    fn order(&self, id: u64, order: Order) {
        let replies = self.replies.clone();
        let ticket = Ticket {
            window: self.number,
            order,
            counts: self.shared.desk.counts(),
            reply: Box::new(move |outcome| {
                // A window that has so many replies unread does not miss another one.
                let _ = replies.try_send(Event::Reply { id, outcome });
            }),
        };
        if let Err(TrySendError::Full(_)) = self.shared.tickets.try_send(ticket) {
            let busy = "too much is asked at once: try again".to_owned();
            self.reply(id, Outcome::Error(busy));
        }
    }

    fn reply(&self, id: u64, outcome: Outcome) {
        let _ = self.replies.try_send(Event::Reply { id, outcome });
    }
}

/// The next batch, while they are wanted; a window that was too slow is told how many it has missed.
async fn next(batches: &mut Option<broadcast::Receiver<Arc<str>>>) -> Arc<str> {
    let Some(receiver) = batches else {
        return std::future::pending().await;
    };
    match receiver.recv().await {
        Ok(batch) => batch,
        Err(RecvError::Lagged(messages)) => json(&Event::Missed { messages }),
        // The session has ended; the state says so.
        Err(RecvError::Closed) => std::future::pending().await,
    }
}

/// Returns false when nobody reads any more.
async fn send(socket: &mut WebSocket, text: &str) -> bool {
    deliver(socket, Message::text(text)).await
}

async fn deliver(socket: &mut WebSocket, message: Message) -> bool {
    matches!(timeout(PATIENCE, socket.send(message)).await, Ok(Ok(())))
}

/// Whether a window is still there. A connection whose cable is out, or whose computer sleeps, does not end by itself.
#[derive(Debug)]
struct Presence {
    heard: Instant,
    asked: Instant,
}

#[derive(Debug, PartialEq, Eq)]
enum Present {
    Yes,
    /// It is to be asked.
    Asked,
    Gone,
}

impl Presence {
    fn new(now: Instant) -> Self {
        Self {
            heard: now,
            asked: now,
        }
    }

    fn heard(&mut self, now: Instant) {
        self.heard = now;
    }

    fn at(&mut self, now: Instant) -> Present {
        if now.duration_since(self.heard) >= PATIENCE {
            return Present::Gone;
        }
        if now.duration_since(self.asked) < PING {
            return Present::Yes;
        }
        self.asked = now;
        Present::Asked
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::desk::Counts;
    use std::sync::mpsc::sync_channel;

    fn shared() -> (Arc<Shared>, std::sync::mpsc::Receiver<Ticket>) {
        let (tickets, orders) = sync_channel(1);
        let shared = Shared {
            desk: Arc::default(),
            tickets,
            outlet: Outlet::new(),
            read_only: false,
            listen: "127.0.0.1:8402".to_owned(),
            token: None,
        };
        (Arc::new(shared), orders)
    }

    #[test]
    fn what_may_not_wait_is_on_the_desk_when_it_was_heard() {
        let (shared, _orders) = shared();
        let mut writer = Window::open(Arc::clone(&shared));
        let mut watcher = Window::open(Arc::clone(&shared));
        // The queue to the session is full: nothing of this goes through it.
        assert!(writer.hear(r#"{"id":1,"do":"enable"}"#));
        let counts = |stops, releases, beats| Counts {
            stops,
            releases,
            beats,
        };
        assert!(writer.hear(r#"{"id":2,"do":"beat"}"#));
        assert!(writer.hear(r#"{"id":3,"do":"release"}"#));
        assert_eq!(shared.desk.counts(), counts(0, 1, 1));
        // Who only watches holds no button, and may stop.
        assert!(watcher.hear(r#"{"id":1,"do":"beat"}"#));
        assert!(watcher.hear(r#"{"id":2,"do":"release"}"#));
        assert!(watcher.hear(r#"{"id":3,"do":"stop"}"#));
        assert_eq!(shared.desk.counts(), counts(1, 1, 1));
        // A connection that is lost lets go of what it holds.
        drop(writer);
        assert_eq!(shared.desk.counts(), counts(1, 2, 1));
        assert!(!watcher.hear("no page of ours"));
    }

    #[test]
    fn a_window_that_answers_nothing_is_gone() {
        let start = Instant::now();
        let at = |milliseconds| start + Duration::from_millis(milliseconds);
        let mut presence = Presence::new(start);
        let asked = |presence: &mut Presence, from: u64, to: u64| {
            let glances = (from..to).step_by(250);
            let told: Vec<_> = glances.map(|time| presence.at(at(time))).collect();
            assert!(!told.contains(&Present::Gone), "{told:?}");
            told.iter().filter(|one| **one == Present::Asked).count()
        };
        assert_eq!(asked(&mut presence, 0, 5_000), 4);
        presence.heard(at(4_900));
        assert_eq!(asked(&mut presence, 5_000, 9_900), 5);
        assert_eq!(presence.at(at(9_900)), Present::Gone);
    }

    #[tokio::test]
    async fn who_is_too_slow_is_told_how_much_was_missed() {
        let (shared, _orders) = shared();
        let mut window = Window::open(Arc::clone(&shared));
        assert!(window.hear(r#"{"id":1,"do":"live","on":true}"#));
        for number in 0..100 {
            let batch: Arc<str> = number.to_string().into();
            shared.outlet.live.send(batch).unwrap();
        }
        assert_eq!(
            &*next(&mut window.live).await,
            r#"{"is":"missed","messages":36}"#
        );
        assert_eq!(&*next(&mut window.live).await, "36");
        // Who wants nothing waits for nothing.
        assert!(window.hear(r#"{"id":2,"do":"live","on":false}"#));
        tokio::select! {
            biased;
            text = next(&mut window.live) => panic!("{text}"),
            () = std::future::ready(()) => {}
        }
    }
}
