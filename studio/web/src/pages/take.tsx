// A recorded take: its joints' curves, the puppet at the playhead, and changes that `keypose
// armature edit` makes. The recorded take stays; changes are kept as a new one.
import { useEffect, useMemo, useState } from 'preact/hooks'

import { useKeys } from '../keys'
import { sentence } from '../words'
import { addressOfTake } from './armature/setup'
import './shoot/shoot.css'
import './armature/armature.css'
import { hold, longer, move, setStep, takeOut } from './take/acts'
import { TakeBar } from './take/bar'
import { CurveLane } from './take/curve_lane'
import { extend, goTo, useSelection } from './take/desk'
import type { TakeDesk } from './take/desk'
import { FrameLane } from './take/frame_lane'
import { PuppetForm } from './take/puppet_form'
import { Side } from './take/side'
import { TakeStage } from './take/stage'
import type { Looks } from './take/stage'
import { byMotion, filmLength, nextBetween, recordedAt } from './take/take_model'
import { useTake } from './take/use_take'
import type { Opened } from './take/use_take'
import { kGutter } from './timeline/desk'
import { Player } from './timeline/player'
import { FrameRuler } from './timeline/ruler'
import { Playhead, ScrollBar } from './timeline/sheet'
import { Help } from './timeline/shortcuts'
import type { HelpLines } from './timeline/shortcuts'
import { Sound } from './timeline/sound'
import './timeline/timeline.css'
import './take/take.css'
import { usePauseWhileHidden, useRestingFrame } from './timeline/use_player'
import { useViewWindow } from './timeline/use_view_window'
import type { Zooming } from './timeline/use_view_window'
import { totalFor } from './timeline/view_window'

/** Joints whose curves are shown at first, the chosen one among them. */
const kShownFirst = 4

const kHelp: HelpLines = [
  ['Space', 'play, pause'],
  ['← →', 'a recorded frame back, on (also , .); Shift: selects'],
  ['↑ ↓', 'on the curve: the value by 1; Shift: by 10; Alt: by 0.1'],
  ['H', 'hold: the selected frames stand as the first'],
  ['[ ]', 'a frame earlier, later'],
  ['D', 'a frame longer'],
  ['Del', 'take the frames out'],
  ['1 2 3 4', 'on ones, twos, threes, fours'],
  ['B', 'played and baked: held, at even pace, smooth'],
  ['A', 'change all joints, or the chosen one'],
  ['Esc', 'select nothing; let a pull be'],
  ['Ctrl+Z', 'undo; Ctrl+Shift+Z: redo'],
  ['Ctrl+S', 'save as a new take'],
  ['V O R', 'from the side; onion skin; play again and again'],
  ['+ − F', 'fewer, more, all frames on the ruler'],
]

/** The chosen joint, and those whose curves are shown with it: at first those that move most. */
function useJoints(opened: Opened) {
  const first = useMemo(() => byMotion(opened.edits.draft!.take), [opened])
  const [chosen, choose] = useState(first[0])
  const [pinned, setPinned] = useState(first.slice(0, kShownFirst))
  const pin = (joint: number, on: boolean) =>
    setPinned((old) => (on ? [...old, joint] : old.filter((one) => one !== joint)))
  return { chosen, choose, pinned, pin }
}

/** Everything that the parts of the page share. */
function useDesk(name: string, opened: Opened): { desk: TakeDesk; zooming: Zooming } {
  const { edits } = opened
  const { take } = edits.draft!
  const player = useMemo(() => new Player(new Sound()), [])
  const length = filmLength(take)
  player.fps = take.fps
  player.length = player.range = length
  usePauseWhileHidden(player)
  useEffect(() => {
    if (player.frame >= length) player.seek(length - 1)
  }, [player, length])
  const zooming = useViewWindow(totalFor(length), player)
  const frame = recordedAt(take, useRestingFrame(player))
  const joints = useJoints(opened)
  const selection = useSelection(take, frame)
  const [allJoints, setAllJoints] = useState(false)
  const joint = take.joints[joints.chosen]
  const rest = { name, take, edits, player, view: zooming.view, frame, joint }
  return { desk: { ...rest, ...joints, ...selection, allJoints, setAllJoints }, zooming }
}

function Sheet({ desk, zooming }: { desk: TakeDesk; zooming: Zooming }) {
  const { take, player, view } = desk
  return (
    <section class="tl-sheet" aria-label="Curves" style={{ '--gutter': `${kGutter}px` }}>
      <div ref={zooming.box} class="tl-lanes">
        <div class="tl-row tl-top">
          <div class="tl-gutter">Frames</div>
          <div class="tl-lane">
            <FrameRuler
              player={player}
              view={view}
              fps={take.fps}
              end={filmLength(take)}
              title="Drag to scrub"
              words={(film) => `, recorded frame ${recordedAt(take, film)}`}
            />
          </div>
        </div>
        <FrameLane desk={desk} />
        <CurveLane desk={desk} />
        <Playhead player={player} view={view} />
      </div>
      <ScrollBar zooming={zooming} />
    </section>
  )
}

function Desk(props: { name: string; opened: Opened; choose: () => void }) {
  const { name, opened } = props
  const { desk, zooming } = useDesk(name, opened)
  const { player, edits, take } = desk
  const [looks, setLooks] = useState<Looks>({ free: false, set: true, onion: 1 })
  const [repeat, setRepeat] = useState(true)
  const [help, setHelp] = useState(false)
  const [saving, setSaving] = useState(false)
  player.repeat = repeat
  const step = (by: number) => goTo(desk, recordedAt(take, player.frame) + by)
  const save = () => setSaving(edits.done.length > 0)
  useKeys({
    ' ': () => player.toggle(),
    ArrowLeft: () => step(-1),
    ArrowRight: () => step(1),
    'shift+ArrowLeft': () => extend(desk, -1),
    'shift+ArrowRight': () => extend(desk, 1),
    ',': () => step(-1),
    '.': () => step(1),
    Home: () => player.seek(0),
    End: () => player.seek(player.length - 1),
    h: () => hold(desk),
    '[': () => move(desk, -1),
    ']': () => move(desk, 1),
    d: () => longer(desk),
    Delete: () => takeOut(desk),
    1: () => setStep(desk, 1),
    2: () => setStep(desk, 2),
    3: () => setStep(desk, 3),
    4: () => setStep(desk, 4),
    a: () => desk.setAllJoints(!desk.allJoints),
    Escape: () => desk.select(null),
    'ctrl+z': () => edits.undo(),
    'ctrl+shift+z': () => edits.redo(),
    'ctrl+y': () => edits.redo(),
    'ctrl+s': save,
    b: () => edits.play(nextBetween(edits.between)),
    r: () => setRepeat(!repeat),
    v: () => setLooks({ ...looks, free: !looks.free }),
    o: () => setLooks({ ...looks, onion: looks.onion > 0 ? 0 : 2 }),
    f: () => zooming.setZoom(1),
    '+': () => zooming.setZoom(1.5 * zooming.zoom),
    '=': () => zooming.setZoom(1.5 * zooming.zoom),
    '-': () => zooming.setZoom(zooming.zoom / 1.5),
    '?': () => setHelp(!help),
  })
  return (
    <main
      class="page whole timeline take-page"
      onClick={(event) => {
        // After a click the space bar plays again; by keyboard the button keeps the focus.
        const button = (event.target as HTMLElement).closest('button')
        if (event.detail > 0 && button) button.blur()
      }}
    >
      <div class="tl-upper">
        <div class="take-stage">
          <nav class="take-head" aria-label="Take">
            <a href="#/armature">Armature</a>
            <span aria-hidden="true">›</span>
            <h1>{name}</h1>
            <button class="quiet small" title="Puppet, character, plate" onClick={props.choose}>
              Files…
            </button>
          </nav>
          <TakeStage desk={desk} opened={opened} looks={looks} setLooks={setLooks}>
            {help && <Help close={() => setHelp(false)} lines={kHelp} />}
          </TakeStage>
        </div>
        <Side desk={desk} />
      </div>
      <TakeBar
        {...{ desk, player, zooming, repeat, setRepeat, help, setHelp, saving, setSaving }}
      />
      <Sheet desk={desk} zooming={zooming} />
    </main>
  )
}

export function TakePage({ name }: { name: string }) {
  const { opened, failure, again } = useTake(name)
  const [choosing, setChoosing] = useState(false)
  const reopen = () => {
    setChoosing(false)
    again()
  }
  if (failure || choosing)
    return (
      <main class="empty take-files">
        <h1>{failure ? `${name} cannot be shown` : `Files of ${name}`}</h1>
        {failure && <p role="alert">{sentence(failure)}</p>}
        <PuppetForm
          take={name}
          opened={reopen}
          close={failure ? undefined : () => setChoosing(false)}
        />
        <a class="button" href="#/armature">
          Back to the armature
        </a>
      </main>
    )
  if (!opened?.edits.draft)
    return (
      <main class="empty" role="status">
        Reads the take, and finds out how its bones move the character …
      </main>
    )
  return <Desk name={name} opened={opened} choose={() => setChoosing(true)} />
}

/** Takes of the project, to look at and to change. */
export function TakeList({ recorded, edited }: { recorded: string[]; edited: string[] }) {
  if (recorded.length + edited.length === 0) return null
  return (
    <section class="take-list" aria-label="Takes">
      <h2>Takes</h2>
      <ul>
        {[...recorded, ...edited].map((name) => (
          <li key={name}>
            <a href={addressOfTake(name)}>{name}</a>
            <span class="small soft">{edited.includes(name) ? 'edited' : 'recorded'}</span>
          </li>
        ))}
      </ul>
      <p class="small soft">Curves of the joints, frames to hold, move and take out, baking.</p>
    </section>
  )
}
