// The light that falls on a take over its plate: where the lamp stands, seen from above, and how
// strong it is. No filmed frame tells it.
import { useEffect, useRef, useState } from 'preact/hooks'

import { api } from '../../api'
import type { StageOption, Step } from '../../api'
import { useStudio } from '../../state'
import { useStages } from '../run/use_stages'

const kNames = ['lamp', 'lamp_from', 'lamp_height', 'brightness'] as const
type Name = (typeof kNames)[number]
type Light = Record<Name, number>
/** What `composite` says of its options. */
type Options = Record<Name, StageOption>

const kRadius = 44

/** @return null if the stage does not have them all */
function optionsOf(all: StageOption[]): Options | null {
  const known = all.filter((one) => (kNames as readonly string[]).includes(one.name))
  if (known.length < kNames.length) return null
  return Object.fromEntries(known.map((one) => [one.name, one])) as Options
}

function lightOf(step: Step, options: Options): Light {
  const valueOf = (name: Name) => [name, Number(step.options[name] ?? options[name].default)]
  return Object.fromEntries(kNames.map(valueOf)) as Light
}

function lowestOf(options: Options): number {
  return options.lamp_height.min ?? 0
}

/** From above, the camera below: the middle is overhead, the rim the lowest height. */
function placeOf(light: Light, lowest: number): [number, number] {
  const far = (kRadius * (90 - light.lamp_height)) / (90 - lowest)
  const angle = (light.lamp_from * Math.PI) / 180
  return [far * Math.sin(angle), far * Math.cos(angle)]
}

function lightAt(x: number, y: number, lowest: number): Pick<Light, 'lamp_from' | 'lamp_height'> {
  const far = Math.min(1, Math.hypot(x, y) / kRadius)
  return {
    lamp_from: far === 0 ? 0 : Math.round((Math.atan2(x, y) * 180) / Math.PI),
    lamp_height: Math.round(90 - (90 - lowest) * far),
  }
}

function sideOf(from: number): string {
  const sides = ['from the camera', 'from the right', 'from behind', 'from the left']
  return sides[(Math.round(from / 90) + 4) % 4]!
}

interface DialProps {
  light: Light
  /** the least height of the lamp, in degrees */
  lowest: number
  change: (light: Light) => void
  keep: (light: Light) => void
}

function Dial({ light, lowest, change, keep }: DialProps) {
  const svg = useRef<SVGSVGElement>(null)
  const [x, y] = placeOf(light, lowest)
  const at = (event: PointerEvent) => {
    const box = svg.current!.getBoundingClientRect()
    const scale = 100 / box.width
    const right = (event.clientX - box.left) * scale - 50
    const down = (event.clientY - box.top) * scale - 50
    return { ...light, ...lightAt(right, down, lowest) }
  }
  const turn = (event: KeyboardEvent) => {
    const ways: Record<string, [number, number]> = {
      ArrowLeft: [-5, 0],
      ArrowRight: [5, 0],
      ArrowUp: [0, 5],
      ArrowDown: [0, -5],
    }
    const way = ways[event.key]
    if (!way) return
    event.preventDefault()
    const from = light.lamp_from + way[0]
    keep({
      ...light,
      lamp_from: from > 180 ? from - 360 : from < -180 ? from + 360 : from,
      lamp_height: Math.min(90, Math.max(lowest, light.lamp_height + way[1])),
    })
  }
  return (
    <svg
      ref={svg}
      class="lamp-dial"
      viewBox="-50 -50 100 100"
      role="slider"
      tabIndex={0}
      aria-label="Where the lamp stands"
      aria-valuenow={light.lamp_from}
      aria-valuetext={`${sideOf(light.lamp_from)}, ${light.lamp_height} degrees high`}
      onKeyDown={turn}
      onPointerDown={(event) => {
        event.currentTarget.setPointerCapture(event.pointerId)
        change(at(event))
      }}
      onPointerMove={(event) => {
        if (event.currentTarget.hasPointerCapture(event.pointerId)) change(at(event))
      }}
      onPointerUp={(event) => keep(at(event))}
    >
      <circle class="rim" r={kRadius} />
      <circle class="half" r={kRadius / 2} />
      <path class="camera" d="M-5 50 L0 41 L5 50 Z" />
      <line x1={0} y1={0} x2={x} y2={y} />
      <circle class="lamp" cx={x} cy={y} r={5} />
    </svg>
  )
}

function Slider(props: {
  words: string
  value: number
  most: number
  shown: string
  change: (value: number) => void
  keep: (value: number) => void
}) {
  return (
    <label class="lamp-slider">
      {props.words} <span class="number">{props.shown}</span>
      <input
        type="range"
        min={0}
        max={props.most}
        value={props.value}
        aria-label={props.words}
        onInput={(event) => props.change(Number(event.currentTarget.value))}
        onChange={(event) => props.keep(Number(event.currentTarget.value))}
      />
    </label>
  )
}

/** @param step  the step that puts the take over its plate */
export function LightForm({ step }: { step: Step }) {
  const stage = useStages()?.find((one) => one.stage === step.stage)
  const options = stage && optionsOf(stage.options)
  return options ? <KnownLightForm step={step} options={options} /> : null
}

function KnownLightForm({ step, options }: { step: Step; options: Options }) {
  const { complain, reload } = useStudio()
  const said = lightOf(step, options)
  const [light, setLight] = useState(said)
  // What pipeline.yaml has, also before the page has read it again; changes go one after the other.
  const kept = useRef(said)
  const writing = useRef({ last: Promise.resolve(), waiting: 0 })
  const saidText = JSON.stringify(said)
  useEffect(() => {
    if (writing.current.waiting > 0) return
    kept.current = JSON.parse(saidText) as Light
    setLight(kept.current)
  }, [saidText])

  const write = async (next: Light) => {
    try {
      let { revision } = await api.project()
      for (const option of kNames) {
        if (next[option] === kept.current[option]) continue
        const isDefault = next[option] === Number(options[option].default)
        const value = isDefault ? null : String(next[option])
        const change = { step: step.step, pose: '', option, value, revision }
        revision = (await api.setOption(change)).revision
        kept.current = { ...kept.current, [option]: next[option] }
      }
    } catch (error) {
      setLight(kept.current)
      complain(error)
    }
    writing.current.waiting -= 1
    await reload()
  }
  const keep = (next: Light) => {
    setLight(next)
    writing.current.waiting += 1
    writing.current.last = writing.current.last.then(() => write(next))
  }
  const brightnessOf = (percent: number) => Math.max(options.brightness.min ?? 0, percent / 100)
  return (
    <div class="stack lamp-form" role="group" aria-label="Light">
      <Slider
        words="Lamp"
        value={Math.round(100 * light.lamp)}
        most={100}
        shown={light.lamp === 0 ? 'none: an even sky' : `${Math.round(100 * light.lamp)} %`}
        change={(value) => setLight({ ...light, lamp: value / 100 })}
        keep={(value) => keep({ ...light, lamp: value / 100 })}
      />
      {light.lamp > 0 && (
        <div class="row">
          <Dial light={light} lowest={lowestOf(options)} change={setLight} keep={keep} />
          <p class="small soft">
            The lamp {sideOf(light.lamp_from)}, {light.lamp_height}° high. Seen from above, the camera
            below; the nearer to the middle, the higher.
          </p>
        </div>
      )}
      <Slider
        words="Brightness"
        value={Math.round(100 * light.brightness)}
        most={300}
        shown={`${Math.round(100 * light.brightness)} %`}
        change={(value) => setLight({ ...light, brightness: brightnessOf(value) })}
        keep={(value) => keep({ ...light, brightness: brightnessOf(value) })}
      />
    </div>
  )
}
