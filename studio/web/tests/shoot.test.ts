import assert from 'node:assert/strict'
import { test } from 'node:test'

import type { ShootEvent, ShootStory } from '../src/api'
import { mainAct } from '../src/pages/shoot/controls'
import {
  aheadOf,
  countsOf,
  nameOf,
  placeOf,
  radiusOf,
  slotsOf,
  spotOf,
} from '../src/pages/shoot/ring_map'
import { afterEnd, afterEvent, fromStory, kNoSession } from '../src/pages/shoot/session'
import type { Session } from '../src/pages/shoot/session'
import {
  draftOf,
  kFirstDraft,
  offersSix,
  problemsOf,
  ringsOf,
  setupOf,
  summaryOf,
  withAmount,
  withPlan,
} from '../src/pages/shoot/setup'
import { sentence } from '../src/words'

const kBlurred = { code: 'blurred', words: 'It is blurred.', do: 'Shoot it again.' }

const begin = (more: object = {}): ShootEvent => ({
  event: 'session',
  pose: 'standing',
  folder: 'photos/standing',
  plan: { rings_deg: [12, 40], angles: 8, flips: 1, focus_stack: 1 },
  total: 32,
  done: 0,
  resumed: false,
  onion_pose: '',
  photographs: {},
  skipped: [],
  ...more,
})

const landed = (
  name: string,
  ring: number,
  angle_deg: number,
  findings: object[] = [],
  flip = 0,
): ShootEvent => ({
  event: 'photograph',
  photograph: name,
  path: `photos/standing/${name}.jpg`,
  entry: { file: `${name}.jpg`, ring, flip, angle_deg, tilt_deg: ring === 1 ? 12 : 40, findings },
  again: false,
})

const told = (...events: ShootEvent[]): Session => events.reduce(afterEvent, kNoSession)
const story = (events: ShootEvent[], running = true): ShootStory => ({
  running,
  number: events.length,
  events,
  exit_code: 0,
  message: running ? '' : 'no camera',
  ports: [],
  plans: {},
  setup: null,
})

test('every photograph has its angle in the rings, and a state', () => {
  const session = told(
    begin({ skipped: ['r1_a045'] }),
    landed('r1_a000', 1, 0),
    landed('r2_a315', 2, 315, [kBlurred]),
    landed('lying_r1_a090', 1, 90, [], 1),
    {
      event: 'state',
      state: 'turning',
      next: 'r1_a090',
      ring: 1,
      flip: 0,
      angle_deg: 90,
      tilt_deg: 12,
      done: 3,
      total: 32,
    },
  )
  const rings = slotsOf(session, 0)
  assert.deepEqual(
    rings.map((ring) => ring.length),
    [8, 8],
  )
  assert.deepEqual(rings[0].map((slot) => slot.state).slice(0, 3), ['done', 'skipped', 'missing'])
  assert.equal(rings[1][7].state, 'warned')
  assert.deepEqual(
    rings
      .flat()
      .filter((slot) => slot.current)
      .map((slot) => slot.angle_deg),
    [90],
  )
  assert.deepEqual(countsOf(rings.flat()), { done: 1, warned: 1, missing: 13, skipped: 1 })
  assert.equal(slotsOf(session, 1)[0][2].photograph?.name, 'lying_r1_a090')
})

test('angles that are rounded in names still find their place', () => {
  const plan = { rings_deg: [10], angles: 48, flips: 0 }
  const session = told(begin({ plan, skipped: ['r1_a008', 'r1_a353'] }), landed('r1_a023', 1, 22.5))
  const states = slotsOf(session, 0)[0].map((slot) => slot.state)
  assert.equal(states[1], 'skipped')
  assert.equal(states[47], 'skipped')
  assert.equal(states[3], 'done')
})

test('names of photographs say where they were taken', () => {
  assert.deepEqual(placeOf('r2_a045'), { flip: 0, ring: 2, angle_deg: 45 })
  assert.deepEqual(placeOf('lying_r1_a000'), { flip: 1, ring: 1, angle_deg: 0 })
  assert.deepEqual(placeOf('lying3_r1_a007'), { flip: 3, ring: 1, angle_deg: 7 })
  assert.equal(placeOf('IMG_0001'), null)
})

test('what is next is what the program says, else the first that is missing', () => {
  const plan = { rings_deg: [12], angles: 4, flips: 1 }
  let session = told(begin({ plan, skipped: ['r1_a090'] }), landed('r1_a000', 1, 0))
  assert.deepEqual(nameOf(aheadOf(session)!), 'r1_a180')
  session = told(
    begin({ plan }),
    ...[0, 90, 180, 270].map((angle) => landed(`r1_a${angle}`, 1, angle)),
  )
  assert.equal(nameOf(aheadOf(session)!), 'lying_r1_a000')
  session = afterEvent(session, { event: 'state', state: 'turning', next: 'lying_r1_a270' })
  assert.equal(nameOf(aheadOf(session)!), 'lying_r1_a270')
  const flips = { ...plan, flips: 0 }
  assert.equal(
    aheadOf(
      told(
        begin({ plan: flips }),
        ...[0, 90, 180, 270]
          .map((angle) => landed('x', 1, angle))
          .map((one, i) => ({ ...one, photograph: `r1_a${i}` })),
      ),
    ),
    null,
  )
  for (const name of ['r2_a045', 'lying_r1_a000', 'lying3_r1_a007'])
    assert.equal(nameOf(placeOf(name)!), name)
})

test('the diagram has 0 degrees at the bottom, and high rings inside', () => {
  assert.deepEqual(spotOf(0, 10), { x: 0, y: 10 })
  assert.ok(Math.abs(spotOf(90, 10).x - 10) < 1e-9)
  const plan = { rings_deg: [40, 12, 12], angles: 8, flips: 0 }
  const radii = [1, 2, 3].map((ring) => radiusOf(ring, plan, 100))
  assert.equal(radii[1], 100)
  assert.ok(radii[0] < radii[2] && radii[2] < radii[1], String(radii))
  assert.ok(Math.min(...radii) > 0)
})

test('a photograph that is shot again is newest, and has another address', () => {
  const session = told(
    begin(),
    landed('r1_a000', 1, 0, [kBlurred]),
    landed('r1_a045', 1, 45),
    landed('r1_a000', 1, 0),
  )
  assert.deepEqual(session.landed, ['r1_a045', 'r1_a000'])
  assert.equal(session.photographs.r1_a000.version, 2)
  assert.deepEqual(session.photographs.r1_a000.findings, [])
})

test('findings can change later, and rings have their own', () => {
  const session = told(
    begin(),
    landed('r1_a000', 1, 0),
    { event: 'findings', photographs: { r1_a000: [kBlurred], r9_a000: [kBlurred] } },
    {
      event: 'ring',
      ring: 1,
      flip: 0,
      moved_px: 4,
      missing_deg: [45],
      findings: [{ code: 'moved', words: 'a', do: 'b' }],
    },
    { event: 'ring', ring: 1, flip: 0, missing_deg: [], findings: [] },
  )
  assert.deepEqual(session.photographs.r1_a000.findings, [kBlurred])
  assert.deepEqual(Object.keys(session.photographs), ['r1_a000'])
  assert.equal(session.rings.length, 1)
  assert.deepEqual(session.rings[0].findings, [])
})

test('a question goes when it is answered, a fault when it is over', () => {
  const ask = {
    event: 'ask',
    ask: 'turn',
    angle_deg: 45,
    words: 'Turn the table to 45 degrees.',
    do: '',
  }
  let session = told(begin(), { event: 'state', state: 'asking', next: 'r1_a045' }, ask)
  assert.equal(session.ask?.angle_deg, 45)
  assert.deepEqual(mainAct(session), { command: 'done', words: 'Done' })
  session = afterEvent(session, { event: 'state', state: 'shooting', next: 'r1_a045' })
  assert.equal(session.ask, null)
  assert.equal(mainAct(session), null)
  session = afterEvent(session, {
    event: 'fault',
    fault: 'camera-gone',
    words: 'The camera is gone.',
    do: 'Plug it in.',
    needs_hand: true,
  })
  assert.equal(session.fault?.needs_hand, true)
  session = afterEvent(session, {
    event: 'recovered',
    fault: 'camera-gone',
    words: 'The camera is back.',
  })
  assert.equal(session.fault, null)
  assert.equal(session.recovered, 'The camera is back.')
})

test('a pause does not call the last photograph the next one', () => {
  const paused = { event: 'state', state: 'paused', next: 'r1_a000', ring: 1, angle_deg: 0 }
  assert.equal(told(begin(), landed('r1_a000', 1, 0), paused).next, '')
  assert.equal(told(begin(), paused).next, 'r1_a000')
})

test('a refused command is said, until one is taken', () => {
  let session = told(begin(), {
    event: 'refused',
    command: 'again',
    words: 'There is no such photograph.',
  })
  assert.equal(session.refused, 'There is no such photograph.')
  session = afterEvent(session, {
    event: 'state',
    state: 'idle',
    next: 'r1_a090',
    ring: 1,
    angle_deg: 90,
  })
  session = afterEvent(session, { event: 'accepted', command: 'skip' })
  assert.equal(session.refused, '')
  assert.deepEqual(session.skipped, ['r1_a090'])
  session = afterEvent(session, { event: 'accepted', command: 'skip', id: 'r2_a000' })
  assert.deepEqual(session.skipped, ['r1_a090', 'r2_a000'])
})

test('the next pose begins with an empty ring and the last one as onion skin', () => {
  const session = told(
    begin(),
    landed('r1_a000', 1, 0),
    begin({ pose: 'bent', folder: 'photos/bent', onion_pose: 'standing' }),
  )
  assert.deepEqual(session.photographs, {})
  assert.equal(session.onionPose, 'standing')
  assert.equal(session.running, true)
})

test('a session that goes on knows what was shot before', () => {
  const entry = landed('r1_a000', 1, 0).entry
  const session = told(begin({ resumed: true, done: 1, photographs: { r1_a000: entry } }))
  assert.equal(session.photographs.r1_a000.path, 'photos/standing/r1_a000.jpg')
  assert.deepEqual(session.landed, ['r1_a000'])
})

test('a page that is opened late sees what one that was there from the start sees', () => {
  const events = [
    begin(),
    landed('r1_a000', 1, 0),
    { event: 'state', state: 'shooting', next: 'r1_a045', done: 1, total: 32 },
  ]
  assert.deepEqual(fromStory(story(events)), told(...events))
  const over = fromStory(
    story([...events, { event: 'ended', complete: false, words: 'Ended.' }], false),
  )
  assert.equal(over.running, false)
  assert.equal(over.failure, 'no camera')
  assert.equal(afterEnd(told(...events), 'the cable').failure, 'the cable')
})

test('events of a later version change nothing', () => {
  const session = told(begin())
  assert.equal(afterEvent(session, { event: 'lens', words: 'x' }), session)
})

test('a form becomes flags, and flags a form', () => {
  const draft = {
    ...kFirstDraft,
    pose: 'standing',
    camera: 'folder' as const,
    folder: '/a:b',
    table: 'grbl' as const,
    port: '/dev/ttyUSB0',
    flips: 1,
  }
  assert.deepEqual(problemsOf(draft), {})
  const setup = setupOf(draft)
  assert.deepEqual(setup, {
    pose: 'standing',
    camera: 'folder:/a:b',
    turntable: 'grbl:/dev/ttyUSB0',
    rings: [12, 40],
    angles: 24,
    flips: 1,
  })
  assert.deepEqual(draftOf(setup), draft)
  assert.equal(setupOf({ ...draft, camera: 'simulated', folder: '' }).camera, 'simulated')
})

test('a form says what is missing, in the field where it is', () => {
  assert.deepEqual(Object.keys(problemsOf(kFirstDraft)), ['pose'])
  assert.ok(problemsOf({ ...kFirstDraft, pose: '-x' }).pose)
  assert.ok(problemsOf({ ...kFirstDraft, pose: 'x', camera: 'folder' }).folder)
  assert.ok(problemsOf({ ...kFirstDraft, pose: 'x', table: 'steps' }).port)
  assert.ok(problemsOf({ ...kFirstDraft, pose: 'x', angles: '2.5' }).angles)
  assert.deepEqual(ringsOf('12° 40; 60'), [12, 40, 60])
  for (const text of ['', 'twelve', '12, 95', Array(13).fill('1').join()])
    assert.equal(ringsOf(text), null)
  assert.equal(
    summaryOf({ ...kFirstDraft, flips: 1 }),
    '2 rings × 24 angles × 2 lays: 96 photographs, one each 15°',
  )
  assert.equal(summaryOf({ ...kFirstDraft, angles: 'x' }), '')
})

test('a pose that was begun keeps its plan', () => {
  const plans = { standing: { rings_deg: [5, 30], angles: 12, flips: 2 } }
  const draft = withPlan({ ...kFirstDraft, pose: 'standing' }, plans)
  assert.deepEqual([draft.rings, draft.angles, draft.flips], ['5, 30', '12', 2])
  assert.deepEqual(withPlan({ ...kFirstDraft, pose: 'bent' }, plans), {
    ...kFirstDraft,
    pose: 'bent',
  })
})

test('words of a program become sentences', () => {
  assert.equal(sentence('turn the table to 45 degrees'), 'Turn the table to 45 degrees.')
  assert.equal(sentence('Is it on?'), 'Is it on?')
  assert.equal(sentence(''), '')
})

test('six photographs are proposed for every pose after the first that has none yet', () => {
  const rest = { name: 'rest', template: true, photographs: 48 }
  const plans = { rest: { rings_deg: [15, 40], angles: 30, flips: 1 } }
  assert.ok(offersSix('wave', [rest], plans))
  assert.ok(!offersSix('rest', [rest], plans))
  assert.ok(!offersSix('wave', [], {}))
  assert.ok(!offersSix('wave', [{ ...rest, photographs: 0 }], {}))
  assert.ok(!offersSix('wave', [rest, { name: 'wave', template: false, photographs: 3 }], plans))
  assert.ok(!offersSix('wave', [rest], { ...plans, wave: { angles: 6 } }))
  const draft = { ...kFirstDraft, pose: 'wave' }
  const six = withAmount(draft, 'six', plans.rest)
  assert.equal(summaryOf(six), '1 ring × 6 angles: 6 photographs, one each 60°')
  assert.equal(six.rings, '15')
  const ring = withAmount(draft, 'ring', plans.rest)
  assert.equal(summaryOf(ring), '2 rings × 30 angles × 2 lays: 120 photographs, one each 12°')
  assert.equal(withAmount(draft, 'own', plans.rest), draft)
})
