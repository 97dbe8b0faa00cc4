'use strict';
// node-canopen takes an unconfigured virtual drive into service: LSS, SDO of every length and kind, NMT. `node drive.js PORT`; what is wrong ends it
// with a message and exit code 1.

const assert = require('assert');
const { Device, LssMode } = require('canopen');
const { connect } = require('./slcan');

const NODE_ID = 10;

/** The machine may be busy: only a drive that hangs takes so long, in milliseconds. */
const PATIENCE = 20000;

/** User memory, a DOMAIN of up to 20,480 bytes. */
const MEMORY = 0x2020;

/** Around what fits a frame, a segment, a block, and what is the longest. */
const LENGTHS = [1, 5, 7, 8, 889, 890, 20000];

/** Next boot-up or heartbeat of the drive with this state. */
function state(device, wanted) {
    return new Promise((resolve, reject) => {
        const timer = setTimeout(() => reject(new Error(`state ${wanted} does not come`)), PATIENCE);
        const hear = device.receive;
        device.receive = function (message) {
            if (message.id === 0x700 + NODE_ID && message.data[0] === wanted) {
                device.receive = hear;
                clearTimeout(timer);
                resolve();
            }
            hear.call(device, message);
        };
    });
}

async function main(port) {
    const device = new Device({ id: 127, enableLss: true });
    const close = await connect(device, port);

    const found = await device.lss.fastscan({ timeout: 60 });
    assert.strictEqual(found.productCode, 0x402);
    const booted = state(device, 0x00);
    await device.lss.configureNodeId(NODE_ID, PATIENCE);
    await device.lss.storeConfiguration(PATIENCE);
    device.lss.switchModeGlobal(LssMode.OPERATION);
    await booted;

    device.eds.addSdoClientParameter(NODE_ID, 0x600 + NODE_ID, 0x580 + NODE_ID);
    device.start();
    const transfer = { deviceId: NODE_ID, timeout: PATIENCE };
    const type = await device.sdo.upload({ ...transfer, index: 0x1000 });
    assert.strictEqual(type.readUInt32LE(), 0x00040192);
    for (const length of LENGTHS) {
        for (const [down, up] of [[false, false], [false, true], [true, false], [true, true]]) {
            const data = Buffer.from(Array.from({ length }, (_, n) => (n * 31 + length) & 0xFF));
            await device.sdo.download({ ...transfer, index: MEMORY, data, blockTransfer: down });
            const read = await device.sdo.upload({ ...transfer, index: MEMORY, blockTransfer: up });
            assert(read.equals(data), `${length} bytes, blocks down ${down}, up ${up}: ${read.length} came`);
        }
    }
    await assert.rejects(device.sdo.upload({ ...transfer, index: 0x5000 }), /06020000|does not exist/i);

    // A heartbeat each 50 ms tells the state.
    const heartbeat = Buffer.from([50, 0]);
    await device.sdo.download({ ...transfer, index: 0x1017, data: heartbeat });
    for (const [command, wanted] of [['startNode', 5], ['stopNode', 4], ['enterPreOperational', 127], ['resetNode', 0]]) {
        const reached = state(device, wanted);
        device.nmt[command](NODE_ID);
        await reached;
    }
    device.stop();
    close();
    console.log('done');
}

main(Number(process.argv[2])).then(() => process.exit(0), (error) => {
    console.error(error);
    process.exit(1);
});
