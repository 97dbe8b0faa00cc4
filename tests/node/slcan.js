'use strict';
// A CAN channel for node-canopen: SLCAN over TCP, as the virtual drive serves it.

const net = require('net');

/** Connects a device of node-canopen; resolves with a function that closes the channel. */
function connect(device, port) {
    return new Promise((resolve, reject) => {
        const socket = net.connect(port, '127.0.0.1');
        socket.setNoDelay(true);
        socket.on('error', reject);
        let text = '';
        socket.on('data', (bytes) => {
            const lines = (text + bytes.toString('latin1')).split('\r');
            text = lines.pop();
            for (const line of lines) {
                const frame = /^t([0-9A-F]{3})([0-8])([0-9A-F]*)$/.exec(line);
                if (frame) {
                    const data = Buffer.from(frame[3].slice(0, 2 * frame[2]), 'hex');
                    device.receive({ id: parseInt(frame[1], 16), data, len: data.length });
                }
            }
        });
        device.addListener('message', ({ id, data }) => {
            const hex = (number, digits) => number.toString(16).toUpperCase().padStart(digits, '0');
            socket.write(`t${hex(id, 3)}${data.length}${data.toString('hex').toUpperCase()}\r`);
        });
        socket.on('connect', () => {
            socket.write('S8\rO\r');
            resolve(() => socket.end());
        });
    });
}

module.exports = { connect };
