// Play, step, and what holds for the whole timeline.
import { useRef } from 'preact/hooks'

import type { Timeline } from '../../api'
import { useFrame, usePlaying } from './desk'
import { Icon } from './icons'
import type { IconName } from './icons'
import { NumberField } from './number_field'
import type { Player } from './player'
import { lengthOf, setFps } from './timeline_model'
import type { Editing, Saving } from './use_timeline'

export function Sign(props: {
  icon: IconName
  label: string
  keys: string
  pressed?: boolean
  disabled?: boolean
  act: () => void
}) {
  return (
    <button
      class="tl-sign"
      aria-label={props.label}
      title={`${props.label} (${props.keys})`}
      aria-pressed={props.pressed}
      disabled={props.disabled}
      onClick={props.act}
    >
      <Icon name={props.icon} />
    </button>
  )
}

/** The playhead's frame of those up to `last`, and its time. */
export function Counter({ player, fps, last }: { player: Player; fps: number; last: number }) {
  const frame = useRef<HTMLSpanElement>(null)
  const time = useRef<HTMLSpanElement>(null)
  useFrame(player, (now) => {
    if (frame.current) frame.current.textContent = String(now)
    if (time.current) time.current.textContent = `${(now / fps).toFixed(2)} s`
  })
  return (
    <div class="tl-counter number">
      <span class="tl-now" ref={frame} />
      <span class="soft">/ {last}</span>
      <span class="tl-time" ref={time} />
    </div>
  )
}

const kSavingWords: Record<Saving, string> = {
  saved: 'Saved',
  waiting: 'Saving…',
  saving: 'Saving…',
  failed: 'Not saved',
}

export interface TransportProps {
  editing: Editing
  timeline: Timeline
  player: Player
  edit: (change: (timeline: Timeline) => Timeline, tag?: string) => void
  setLoop: (loop: boolean) => void
  repeat: boolean
  setRepeat: (repeat: boolean) => void
  zoom: number
  setZoom: (zoom: number) => void
  help: boolean
  setHelp: (help: boolean) => void
}

/** `by`: frames of a step; a take on twos goes by two. */
export function PlayButtons(props: {
  player: Player
  repeat: boolean
  setRepeat: (repeat: boolean) => void
  by?: number
}) {
  const { player, repeat, setRepeat, by = 1 } = props
  const playing = usePlaying(player)
  return (
    <div class="tl-group">
      <Sign icon="first" label="First frame" keys="Home" act={() => player.seek(0)} />
      <Sign
        icon="back"
        label="A frame back"
        keys=","
        act={() => player.seek(player.frame - by, true)}
      />
      <button
        class="main tl-play"
        aria-label={playing ? 'Pause' : 'Play'}
        title={`${playing ? 'Pause' : 'Play'} (Space)`}
        onClick={() => player.toggle()}
      >
        <Icon name={playing ? 'pause' : 'play'} />
      </button>
      <Sign
        icon="forward"
        label="A frame on"
        keys="."
        act={() => player.seek(player.frame + by, true)}
      />
      <Sign
        icon="last"
        label="Last frame"
        keys="End"
        act={() => player.seek(player.length - 1)}
      />
      <Sign
        icon="repeat"
        label="Play again and again"
        keys="R"
        pressed={repeat}
        act={() => setRepeat(!repeat)}
      />
    </div>
  )
}

/** Undo and redo of what is edited. */
export function History(props: {
  editing: Pick<Editing, 'canUndo' | 'canRedo' | 'undo' | 'redo'>
}) {
  const { editing } = props
  return (
    <div class="tl-group">
      <Sign icon="undo" label="Undo" keys="Ctrl+Z" disabled={!editing.canUndo} act={editing.undo} />
      <Sign
        icon="redo"
        label="Redo"
        keys="Ctrl+Shift+Z"
        disabled={!editing.canRedo}
        act={editing.redo}
      />
    </div>
  )
}

export function HelpButton({ help, setHelp }: Pick<TransportProps, 'help' | 'setHelp'>) {
  return (
    <button
      class="tl-sign"
      aria-label="Keys of the keyboard"
      title="Keys of the keyboard (?)"
      aria-pressed={help}
      onClick={() => setHelp(!help)}
    >
      ?
    </button>
  )
}

function Whole({ timeline, edit, setLoop }: TransportProps) {
  return (
    <>
      <div class="choice" role="group" aria-label="Frames that each picture stands">
        {['Ones', 'Twos', 'Threes'].map((name, i) => (
          <button
            key={name}
            aria-pressed={timeline.step === i + 1}
            onClick={() => edit((now) => ({ ...now, step: i + 1 }))}
          >
            {name}
          </button>
        ))}
      </div>
      <button
        aria-pressed={timeline.loop}
        title="The last key is the first pose again, and the pace does not jump at the seam"
        onClick={() => setLoop(!timeline.loop)}
      >
        Loop
      </button>
      <label class="tl-fps">
        <NumberField
          label="Frames per second"
          value={timeline.fps}
          digits={Number.isInteger(timeline.fps) ? 0 : 3}
          min={1}
          max={120}
          change={(fps) => edit((now) => setFps(now, fps))}
        />
        fps
      </label>
    </>
  )
}

export function Zoom({ zoom, setZoom }: Pick<TransportProps, 'zoom' | 'setZoom'>) {
  return (
    <div class="choice" role="group" aria-label="Zoom of the ruler">
      <button
        aria-label="Show more frames"
        title="Show more frames (−)"
        disabled={zoom === 1}
        onClick={() => setZoom(zoom / 1.5)}
      >
        −
      </button>
      <button aria-pressed={zoom === 1} title="Show all frames (F)" onClick={() => setZoom(1)}>
        Fit
      </button>
      <button
        aria-label="Show fewer frames"
        title="Show fewer frames (+)"
        onClick={() => setZoom(zoom * 1.5)}
      >
        +
      </button>
    </div>
  )
}

export function Transport(props: TransportProps) {
  const { editing, timeline, player } = props
  return (
    <div class="tl-transport" role="toolbar" aria-label="Transport">
      <PlayButtons {...props} />
      <Counter player={player} fps={timeline.fps} last={Math.max(0, lengthOf(timeline) - 1)} />
      <Whole {...props} />
      <div class="tl-right">
        <span
          class={editing.saving === 'failed' ? 'bad small' : 'soft small'}
          role="status"
          title="Each change is written to the project’s file, pipeline.yaml"
        >
          {kSavingWords[editing.saving]}
        </span>
        <History editing={editing} />
        <Zoom {...props} />
        <HelpButton {...props} />
      </div>
    </div>
  )
}
