// A session of node-mavlink: `node node_session.mjs udp:PORT | tcp:HOST:PORT`. It prints what it asks for and what it
// gets. Modules are found in NODE_PATH's folder, or beside this file.
import { createSocket } from 'node:dgram'
import { createRequire } from 'node:module'
import { connect } from 'node:net'
import { PassThrough } from 'node:stream'

const { MavLinkPacketParser, MavLinkPacketSplitter, MavLinkProtocolV2, common, minimal } =
  createRequire(import.meta.url)('node-mavlink')

const PATIENCE = 60000 // ms
const STATES = ['disarmed', 'rest', 'manual', 'gait', 'mission', 'paused', 'home', 'surface', 'held']
const BASE = 100
const REGISTRY = { ...minimal.REGISTRY, ...common.REGISTRY }
const protocol = new MavLinkProtocolV2(255, 190)
const waiting = new Set()
let sequence = 0
let write = () => {}

/** Open the line; return its bytes as a stream. */
function open(address) {
  const [kind, ...place] = address.split(':')
  if (kind === 'tcp') {
    const line = connect(Number(place[1]), place[0])
    write = bytes => line.write(bytes)
    return line
  }
  const line = createSocket('udp4')
  const stream = new PassThrough()
  line.on('message', (bytes, from) => {
    write = out => line.send(out, from.port, from.address)
    stream.write(bytes)
  })
  line.bind(Number(place[0]), '127.0.0.1')
  return stream
}

function say(message, fields) {
  write(protocol.serialize(Object.assign(message, fields), sequence++))
  sequence &= 255
}

/** Wait for a message of a class whose fields fit. */
function wait(kind, fits = () => true) {
  return new Promise((resolve, reject) => {
    const entry = { kind, fits, resolve }
    waiting.add(entry)
    const timer = setTimeout(() => reject(new Error(`no ${kind.MSG_NAME} in ${PATIENCE / 1000} s`)), PATIENCE)
    entry.resolve = data => {
      clearTimeout(timer)
      waiting.delete(entry)
      resolve(data)
    }
  })
}

async function command(name, what, ...values) {
  const end = Date.now() + PATIENCE
  while (Date.now() < end) {
    const answer = wait(common.CommandAck, ack => ack.command === what)
    const fields = { targetSystem: 1, targetComponent: 1, command: what, confirmation: 0 }
    for (let k = 0; k < 7; k++) fields[`_param${k + 1}`] = values[k] ?? 0
    say(new common.CommandLong(), fields)
    const ack = await answer
    if (ack.result === 0) return console.log(`${name}: accepted`)
    await new Promise(resolve => setTimeout(resolve, 500))
  }
  throw new Error(`${name}: refused`)
}

/** Check the mode of the next heartbeat. */
async function mode(expected) {
  const heart = await wait(minimal.Heartbeat)
  const found = `${STATES[heart.customMode - BASE]}, ${heart.baseMode & 128 ? 'armed' : 'disarmed'}`
  console.log(`    ${found}`)
  if (found !== expected) throw new Error(`mode ${found}, not ${expected}`)
}

async function upload(type, items) {
  const target = { targetSystem: 1, targetComponent: 1, missionType: type }
  const done = wait(common.MissionAck, ack => ack.missionType === type)
  const requests = { kind: common.MissionRequestInt, fits: m => m.missionType === type }
  requests.resolve = m => say(new common.MissionItemInt(), { ...target, seq: m.seq, autocontinue: 1, ...items[m.seq] })
  waiting.add(requests)
  say(new common.MissionCount(), { ...target, count: items.length })
  const ack = await done
  waiting.delete(requests)
  return ack.type
}

async function download(type) {
  const target = { targetSystem: 1, targetComponent: 1, missionType: type }
  const answer = wait(common.MissionCount, m => m.missionType === type)
  say(new common.MissionRequestList(), target)
  const { count } = await answer
  const items = []
  for (let seq = 0; seq < count; seq++) {
    const item = wait(common.MissionItemInt, m => m.seq === seq && m.missionType === type)
    say(new common.MissionRequestInt(), { ...target, seq })
    items.push(await item)
  }
  return items
}

async function roundTrip(name, type, items) {
  const result = await upload(type, items)
  if (result !== 0) throw new Error(`${name}: result ${result}`)
  const found = await download(type)
  const close = (a, b) => Object.is(a, b) || Math.abs(a - b) <= 1e-6 * Math.abs(a)
  const same = items.every((item, k) => Object.keys(item).every(key => close(item[key], found[k][key])))
  if (found.length !== items.length || !same) throw new Error(`${name}: comes back another`)
  console.log(`${name}: ${found.length} items up and down, the same`)
}

async function main(address) {
  const reader = open(address).pipe(new MavLinkPacketSplitter()).pipe(new MavLinkPacketParser())
  reader.on('data', packet => {
    const kind = REGISTRY[packet.header.msgid]
    if (!kind) return
    const data = packet.protocol.data(packet.payload, kind)
    if (kind === common.StatusText) console.log(`    says: ${data.text}`)
    for (const entry of [...waiting]) if (entry.kind === kind && entry.fits(data)) entry.resolve(data)
  })
  const heart = await wait(minimal.Heartbeat)
  console.log(`heartbeat, type ${heart.type}, mode ${STATES[heart.customMode - BASE]}`)
  const beat = { type: 6, autopilot: 8, baseMode: 0, customMode: 0, systemStatus: 0, mavlinkVersion: 3 }
  setInterval(() => say(new minimal.Heartbeat(), beat), 1000)

  const set = async (paramId, paramValue) => {
    const answer = wait(common.ParamValue, m => m.paramId === paramId)
    say(new common.ParamSet(), { targetSystem: 1, targetComponent: 1, paramId, paramValue, paramType: 9 })
    return (await answer).paramValue
  }
  await set('LINK_RATE', 115200)
  const last = wait(common.ParamValue, m => m.paramIndex === m.paramCount - 1)
  say(new common.ParamRequestList(), { targetSystem: 1, targetComponent: 1 })
  console.log(`${(await last).paramCount} parameters, LEARNING = ${(await set('LEARNING', 0.25)).toFixed(2)}`)

  const at = await wait(common.GlobalPositionInt)
  console.log(`position ${(at.lat / 1e7).toFixed(6)} ${(at.lon / 1e7).toFixed(6)}`)
  const corner = (n, e) => ({ frame: 0, command: 5001, param1: 4, x: at.lat + n, y: at.lon + e, z: 0 })
  await roundTrip('fence', 1, [corner(-4000, -4000), corner(-4000, 4000), corner(4000, 4000), corner(4000, -4000)])
  const point = (n, e, z) => ({ frame: 6, command: 16, param1: 0, param2: 3, x: at.lat + n, y: at.lon + e, z })
  await roundTrip('mission', 0, [point(1000, 0, -0.5), point(1000, 1000, -1), point(0, 1000, -0.5)])
  await command('arm', 400, 1)
  await command('start', 300)
  await mode('mission, armed')
  await command('pause', 193, 0)
  await mode('paused, armed')
  await command('continue', 193, 1)
  await command('return', 20)
  await mode('home, armed')
  await command('surface', 21)
  await command('disarm', 400, 0)
  await mode('rest, disarmed')
  for (const missionType of [0, 1]) {
    const done = wait(common.MissionAck, ack => ack.missionType === missionType)
    say(new common.MissionClearAll(), { targetSystem: 1, targetComponent: 1, missionType })
    if ((await done).type !== 0) throw new Error('not cleared')
  }
  console.log('mission and fence cleared')
  process.exit(0)
}

main(process.argv[2]).catch(error => {
  console.error(error)
  process.exit(1)
})
