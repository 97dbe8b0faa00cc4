// The connection with the panel: requests with their replies, the newest state, frames. It is made again when it is lost.

const waiting = new Map();
const listeners = new Set();
let socket = null;
let last = 0;

/** What this window knows. */
export const known = {
  connected: false,
  window: null,
  readOnly: false,
  writer: null,
  version: "",
  state: null,
  // The panel does not let this window in: its address has no token, or another one.
  refused: false,
};

/** Whether this window is the one that writes. */
export function hasControl() {
  return known.connected && !known.readOnly && known.writer === known.window;
}

/** Whether it may write now: while the motor is measured nothing else is. */
export function mayWrite() {
  return hasControl() && !known.state?.tuning;
}

/** Calls back with what is new: "state", "connection", "writer"; "frames", "live" and "missed" with their event. */
export function listen(listener) {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

function tell(what, detail) {
  for (const listener of [...listeners]) listener(what, detail);
}

/** Sends an order; the promise has what came of it. */
export function order(what, details = {}) {
  return new Promise((resolve, reject) => {
    if (!known.connected) {
      reject(new Error("there is no connection with the panel"));
      return;
    }
    const id = (last += 1);
    waiting.set(id, { resolve, reject });
    socket.send(JSON.stringify({ id, do: what, ...details }));
  });
}

/** Sends something that has no reply: what a person must be able to say at once. */
export function say(what) {
  if (known.connected) socket.send(JSON.stringify({ id: (last += 1), do: what }));
}

function hear(event) {
  switch (event.is) {
    case "hello":
      known.window = event.window;
      known.readOnly = event.read_only;
      known.version = event.version;
      known.connected = true;
      tell("connection");
      break;
    case "state":
      known.state = event;
      tell("state");
      break;
    case "writer":
      known.writer = event.window;
      tell("writer");
      break;
    case "frames":
    case "live":
    case "missed":
      tell(event.is, event);
      break;
    case "reply": {
      const asked = waiting.get(event.id);
      waiting.delete(event.id);
      if (!asked) break;
      if ("error" in event) asked.reject(new Error(event.error));
      else asked.resolve(event.done);
      break;
    }
  }
}

/** Connects, and again when the connection is lost. */
export function connect() {
  const token = new URLSearchParams(location.search).get("token");
  const query = token ? `?token=${encodeURIComponent(token)}` : "";
  socket = new WebSocket(`ws://${location.host}/ws${query}`);
  socket.onmessage = (message) => hear(JSON.parse(message.data));
  socket.onclose = () => {
    const was = known.connected;
    known.connected = false;
    // A socket that was refused does not tell why; this question does.
    if (!was) fetch(`/token${query}`).then(({ status }) => { known.refused = status === 401; }, () => {}).then(() => tell("connection"));
    for (const asked of waiting.values()) asked.reject(new Error("the connection with the panel was lost"));
    waiting.clear();
    if (was) tell("connection");
    setTimeout(connect, 1000);
  };
}
