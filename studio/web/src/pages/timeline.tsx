// The timeline: keys on a frame ruler under the playing character.
import { useEffect, useMemo, useRef, useState } from 'preact/hooks'

import type { Timeline } from '../api'
import { useStudio } from '../state'
import { kGutter } from './timeline/desk'
import type { Desk } from './timeline/desk'
import { Inspector } from './timeline/inspector'
import { KeyTable } from './timeline/key_table'
import { FramesNote } from './timeline/make_frames'
import { kNoOnion } from './timeline/onion'
import { Player } from './timeline/player'
import { RegionsTable } from './timeline/regions_table'
import { Sheet } from './timeline/sheet'
import type { Asked } from './timeline/sheet'
import { Help, useShortcuts } from './timeline/shortcuts'
import { Stage } from './timeline/stage'
import {
  copyKey,
  deleteKey,
  framesOf,
  holdOf,
  lengthOf,
  moveKey,
  Refusal,
  setHold,
  setLoop,
} from './timeline/timeline_model'
import { Transport } from './timeline/transport'
import { useFrames, useStale } from './timeline/use_frames'
import type { Made } from './timeline/use_frames'
import { usePauseWhileHidden } from './timeline/use_player'
import { useSound } from './timeline/use_sound'
import { useTimeline } from './timeline/use_timeline'
import type { Editing } from './timeline/use_timeline'
import { useViewWindow } from './timeline/use_view_window'
import { totalFor, xOf } from './timeline/view_window'
import './timeline/timeline.css'

const kTabs = ['Key', 'Table', 'Regions'] as const
type Tab = (typeof kTabs)[number]

function SidePanel({ desk, order }: { desk: Desk; order: boolean }) {
  const [tab, setTab] = useState<Tab>('Key')
  const turn = (event: KeyboardEvent) => {
    const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key] ?? 0
    if (by === 0) return
    const next = kTabs[(kTabs.indexOf(tab) + by + kTabs.length) % kTabs.length]
    setTab(next)
    document.getElementById(`tl-tab-${next}`)?.focus()
  }
  return (
    <aside class="tl-side" aria-label="Details">
      <div class="tl-tabs" role="tablist" aria-label="Details" onKeyDown={turn}>
        {kTabs.map((name) => (
          <button
            key={name}
            id={`tl-tab-${name}`}
            role="tab"
            aria-selected={name === tab}
            aria-controls="tl-panel"
            tabIndex={name === tab ? 0 : -1}
            onClick={() => setTab(name)}
          >
            {name}
          </button>
        ))}
      </div>
      <div id="tl-panel" class="tl-panel" role="tabpanel" aria-labelledby={`tl-tab-${tab}`}>
        {order && (
          <p class="tl-order small">
            The project gives only the order of its poses. The first change here writes times into
            pipeline.yaml.
          </p>
        )}
        {tab === 'Key' && <Inspector desk={desk} />}
        {tab === 'Table' && <KeyTable desk={desk} />}
        {tab === 'Regions' && <RegionsTable desk={desk} />}
      </div>
    </aside>
  )
}

/** Keys of the keyboard while a block has the focus. */
function keyPressed(event: KeyboardEvent, index: number, desk: Desk): void {
  const sideways = { ArrowLeft: -1, ArrowRight: 1 }[event.key] ?? 0
  const along = { ArrowUp: -1, ArrowDown: 1 }[event.key] ?? 0
  if (sideways === 0 && along === 0) return
  event.preventDefault()
  if (along !== 0) return blockOf(index + along)?.focus()
  const by = sideways * (event.shiftKey ? 10 : 1)
  if (event.altKey)
    desk.edit((now) => setHold(now, index, holdOf(now, index) + by), `hold ${index}`)
  else desk.edit((now) => moveKey(now, index, framesOf(now)[index] + by), `move ${index}`)
}

const blockOf = (index: number) =>
  document.querySelector<HTMLElement>(`.tl-block[data-key="${index}"]`)

/** Once the block is drawn, which may be new. */
function focusKey(index: number): void {
  requestAnimationFrame(() => blockOf(index)?.focus())
}

/** The edits of the page: refusals in words, drags as previews, new keys selected. */
function useEdits(editing: Editing) {
  const { tell } = useStudio()
  const [preview, setPreview] = useState<Timeline | null>(null)
  const [chosen, setChosen] = useState(0)
  const timeline = preview ?? editing.timeline
  const attempt = (act: () => void) => {
    try {
      act()
    } catch (error) {
      if (!(error instanceof Refusal)) throw error
      tell(error.message)
    }
  }
  const edit: Desk['edit'] = (change, tag) =>
    attempt(() => editing.commit(change(editing.timeline), tag))
  const insert: Desk['insert'] = (change) =>
    attempt(() => {
      const { timeline: next, index } = change(editing.timeline)
      editing.commit(next)
      setChosen(index)
      focusKey(index)
    })
  const selected = Math.min(chosen, timeline.keys.length - 1)
  return { timeline, selected, select: setChosen, edit, insert, preview: setPreview }
}

/** Keeps the player's numbers as the frames or, before there are any, the timeline have them. */
function usePlayer(player: Player, made: Made | null, timeline: Timeline, total: number): void {
  const frames = made
    ? Math.max(1, Math.round((made.frames.count * timeline.fps) / made.frames.fps))
    : lengthOf(timeline)
  // A loop's last frame is its first one again.
  player.length = timeline.loop && frames > 1 ? frames - 1 : frames
  player.fps = timeline.fps
  player.range = Math.max(total, frames)
  usePauseWhileHidden(player)
}

function Desktop({ editing, made }: { editing: Editing; made: Made | null }) {
  const { project, tell } = useStudio()
  const sound = useSound()
  const player = useMemo(() => new Player(sound.sound), [sound.sound])
  const [onion, setOnion] = useState(kNoOnion)
  const [repeat, setRepeat] = useState(true)
  const [help, setHelp] = useState(false)
  const [asked, ask] = useState<Asked | null>(null)
  const main = useRef<HTMLElement>(null)
  const edits = useEdits(editing)
  const { timeline, selected } = edits
  // A drag does not change the scale that it is measured with.
  const total = totalFor(Math.max(lengthOf(editing.timeline), made?.frames.count ?? 0))
  const zooming = useViewWindow(total, player)
  usePlayer(player, made, editing.timeline, total)
  player.repeat = repeat
  useEffect(
    () =>
      player.watchState(() => {
        if (main.current) main.current.dataset.dropped = String(player.dropped)
      }),
    [player],
  )
  const stale = useStale(editing.timeline, editing.order, made)
  const poses = project.poses.map((pose) => pose.name)
  const desk: Desk = { ...edits, poses, player, made, view: zooming.view }

  const loop = (on: boolean) => {
    const { timeline: next, added } = setLoop(editing.timeline, on)
    edits.edit(() => next)
    if (added) tell(`A loop ends with its first pose: a key of ${next.keys[0].pose} was added.`)
  }
  const askAtPlayhead = () =>
    ask({ frame: player.frame, x: kGutter + Math.max(0, xOf(zooming.view, player.frame)) })
  const remove = () => {
    edits.edit((now) => deleteKey(now, selected))
    focusKey(Math.max(0, selected - 1))
  }
  const keepSkin = () => {
    const others = onion.chosen.filter((frame) => frame !== player.frame)
    setOnion({ ...onion, on: true, chosen: [...others, player.frame] })
  }
  useShortcuts({
    ' ': () => player.toggle(),
    ',': () => player.seek(player.frame - 1, true),
    '.': () => player.seek(player.frame + 1, true),
    Home: () => player.seek(0),
    End: () => player.seek(player.length - 1),
    r: () => setRepeat(!repeat),
    o: () => setOnion({ ...onion, on: !onion.on }),
    'Shift+o': keepSkin,
    k: askAtPlayhead,
    f: () => zooming.setZoom(1),
    '+': () => zooming.setZoom(1.5 * zooming.zoom),
    '=': () => zooming.setZoom(1.5 * zooming.zoom),
    '-': () => zooming.setZoom(zooming.zoom / 1.5),
    '?': () => setHelp(!help),
    Delete: remove,
    'Ctrl+d': () => edits.insert((now) => copyKey(now, selected, player.frame)),
    'Ctrl+z': editing.undo,
    'Ctrl+Shift+z': editing.redo,
    'Ctrl+y': editing.redo,
  })
  return (
    <main
      ref={main}
      class="page whole timeline"
      data-dropped="0"
      onClick={(event) => {
        // After a click the space bar plays again; by keyboard the button keeps the focus.
        const button = (event.target as HTMLElement).closest('button:not(.tl-block)')
        if (event.detail > 0 && button instanceof HTMLElement) button.blur()
      }}
    >
      <h1 class="hidden">Timeline</h1>
      <div class="tl-upper">
        <Stage
          made={made}
          player={player}
          fps={timeline.fps}
          onion={onion}
          setOnion={setOnion}
        >
          <FramesNote editing={editing} made={made !== null} stale={stale} />
          {help && <Help close={() => setHelp(false)} />}
        </Stage>
        <SidePanel desk={desk} order={editing.order} />
      </div>
      <Transport
        editing={editing}
        timeline={timeline}
        player={player}
        edit={edits.edit}
        setLoop={loop}
        repeat={repeat}
        setRepeat={setRepeat}
        zoom={zooming.zoom}
        setZoom={zooming.setZoom}
        help={help}
        setHelp={setHelp}
      />
      <Sheet
        desk={desk}
        zooming={zooming}
        sound={sound}
        asked={asked}
        ask={ask}
        keyDown={(event, index) => keyPressed(event, index, desk)}
      />
    </main>
  )
}

function OnePose() {
  return (
    <main class="empty">
      <h1>An animation needs a second pose</h1>
      <p>It goes from one pose of the figure to another. Photograph the next pose and add it.</p>
      <a class="button" href="#/poses">
        Go to the poses
      </a>
    </main>
  )
}

function NoKeys({ editing }: { editing: Editing }) {
  const { project } = useStudio()
  const [first, second] = project.poses.map((pose) => pose.name)
  const keys = [
    { pose: first, at: 0 },
    { pose: second, at: 1 },
  ]
  return (
    <main class="empty">
      <h1>No keys yet</h1>
      <p>Begin with the first two poses, one second apart; the rest is done on the ruler.</p>
      <button class="main" onClick={() => editing.commit({ ...editing.timeline, keys })}>
        Set two keys
      </button>
    </main>
  )
}

export function TimelinePage() {
  const { project } = useStudio()
  const { made, ready } = useFrames()
  const editing = useTimeline(made?.frames ?? null)
  if (project.poses.length < 2) return <OnePose />
  if (!ready || !editing) return <main class="empty">Reading the timeline…</main>
  if (editing.timeline.keys.length < 2) return <NoKeys editing={editing} />
  return <Desktop editing={editing} made={made} />
}
