// The sound's waveform under the ruler.
import { useEffect, useRef } from 'preact/hooks'

import { cssColor } from '../../css_color'
import { clearedCanvas, useTheme } from './desk'
import type { Desk } from './desk'
import { Icon } from './icons'
import { NumberField } from './number_field'
import type { Sound } from './sound'
import type { SoundState } from './use_sound'
import { frameAt } from './view_window'
import type { ViewWindow } from './view_window'

function drawWave(canvas: HTMLCanvasElement, view: ViewWindow, fps: number, sound: Sound): void {
  const context = clearedCanvas(canvas)
  if (!context) return
  const height = canvas.clientHeight
  const middle = height / 2
  context.fillStyle = cssColor(sound.on ? '--soft' : '--line')
  const peakAt = (x: number) =>
    ((view.start + x / view.scale) / fps - sound.offset) * sound.peaksPerSecond
  for (let x = 0; x < canvas.clientWidth; ++x) {
    const from = Math.max(0, Math.floor(peakAt(x)))
    const to = Math.min(sound.peaks.length / 2, Math.max(from + 1, Math.floor(peakAt(x + 1))))
    if (peakAt(x) < 0 || from >= to) continue
    let low = 0
    let high = 0
    for (let i = from; i < to; ++i) {
      low = Math.min(low, sound.peaks[2 * i])
      high = Math.max(high, sound.peaks[2 * i + 1])
    }
    const reach = middle - 3
    context.fillRect(x, middle - high * reach, 1, Math.max(1, (high - low) * reach))
  }
}

function ChooseSound({ choose }: { choose: (file: File) => void }) {
  return (
    <label class="tl-choose">
      <input
        type="file"
        accept="audio/*"
        class="hidden"
        onChange={(event) => {
          const file = event.currentTarget.files?.[0]
          if (file) choose(file)
          event.currentTarget.value = ''
        }}
      />
      <span class="button">Choose a sound…</span>
    </label>
  )
}

function SoundHead({ state, fps }: { state: SoundState; fps: number }) {
  const { sound } = state
  return (
    <>
      <span class="tl-file" title={`${sound.name}, the sound of the project's films`}>
        {sound.name}
      </span>
      <div class="tl-tools">
        <button
          class="quiet"
          aria-pressed={sound.on}
          aria-label="Sound"
          title={sound.on ? 'Heard while playing; press to mute' : 'Muted'}
          onClick={() => state.setOn(!sound.on)}
        >
          <Icon name={sound.on ? 'sound' : 'mute'} />
        </button>
        <label title="The frame at which the sound begins">
          from
          <NumberField
            label="Frame at which the sound begins"
            value={Math.round(sound.offset * fps)}
            change={(frame) => state.setOffset(frame / fps)}
          />
        </label>
        <button
          class="quiet"
          aria-label="Remove the sound"
          title="Remove the sound"
          onClick={state.remove}
        >
          <Icon name="bin" />
        </button>
      </div>
    </>
  )
}

export function SoundLane({ desk, state }: { desk: Desk; state: SoundState }) {
  const { view, timeline, player } = desk
  const canvas = useRef<HTMLCanvasElement>(null)
  const theme = useTheme()
  const { sound, stamp } = state
  useEffect(() => {
    if (canvas.current) drawWave(canvas.current, view, timeline.fps, sound)
  }, [view, timeline.fps, sound, stamp, theme])
  const scrub = (event: PointerEvent) => {
    const x = event.clientX - canvas.current!.getBoundingClientRect().left
    player.seek(frameAt(view, x), true)
  }
  if (!sound.there)
    return (
      <div class="tl-row tl-sound none">
        <div class="tl-gutter">Sound</div>
        <div class="tl-lane">
          <ChooseSound choose={state.choose} />
          <span class="soft small">
            to time against (WAV, FLAC, MP3, Opus); it becomes a file of the project, and its films
            carry it
          </span>
        </div>
      </div>
    )
  return (
    <div class="tl-row tl-sound">
      <div class="tl-gutter">
        <SoundHead state={state} fps={timeline.fps} />
      </div>
      <div class="tl-lane">
        <canvas
          ref={canvas}
          aria-hidden="true"
          onPointerDown={(event) => {
            event.currentTarget.setPointerCapture(event.pointerId)
            scrub(event)
          }}
          onPointerMove={(event) => {
            if (event.currentTarget.hasPointerCapture(event.pointerId)) scrub(event)
          }}
        />
      </div>
    </div>
  )
}
