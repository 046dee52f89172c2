import assert from 'node:assert/strict'
import { test } from 'node:test'

import { mirroredName, withMirrored } from '../src/pages/landmarks/mirroring'
import { kEmptyHistory, picksOf, withPick } from '../src/pages/landmarks/pick_history'

test('a name says the other side', () => {
  const pairs = [
    ['left hand', 'right hand'],
    ['RIGHT foot', 'LEFT foot'],
    ['foot.L', 'foot.R'],
    ['r_ear', 'l_ear'],
    ['ear', 'ear mirrored'],
  ]
  for (const [name, other] of pairs) assert.equal(mirroredName(name), other)
})

test('with a net it is suggested, without one it waits on the template; what has its partner is left', () => {
  const place = { face: 1, barycentric: [1, 0, 0] as [number, number, number] }
  let sheet = withPick(kEmptyHistory.now, 'rest', { ...place, name: 'left hand' })
  sheet = withPick(sheet, 'rest', { ...place, name: 'ear.L' })
  sheet = withPick(sheet, 'rest', { ...place, name: 'ear.R' })
  const one = (of: string, target: typeof place | null) => ({ of, source: place, target, off: 0 })
  const made = withMirrored(sheet, 'rest', 'wave', [
    one('left hand', place),
    one('ear.L', place),
    one('gone', place),
  ])
  assert.deepEqual([made.suggested, made.open], [1, 0])
  assert.equal(made.sheet.suggestions.get('wave')![0].name, 'right hand')
  assert.ok(made.sheet.suggestions.get('wave')![0].confidence > 0.8)
  const alone = withMirrored(sheet, 'rest', 'wave', [one('left hand', null)])
  assert.deepEqual([alone.suggested, alone.open], [0, 1])
  assert.ok(picksOf(alone.sheet, 'rest').some((pick) => pick.name === 'right hand'))
})
