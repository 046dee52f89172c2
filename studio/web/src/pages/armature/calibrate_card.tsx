// The puppet's zero position, its check, which sensors answer, gear ratios: `keypose armature
// calibrate` as a conversation.
import { useEffect, useState } from 'preact/hooks'

import { get, send } from '../../api'
import { useStudio } from '../../state'
import { sentence } from '../../words'
import type { ArmatureSetup } from './armature_api'
import { kSimulated } from './setup'

interface Story {
  running: boolean
  events: { event: string; words?: string }[]
  exit_code: number
  message: string
}
type What = 'zero' | 'verify' | 'wiggle' | 'gears'

const kAddress = '/api/armature/calibration'
const kLook_ms = 300

const kWays: { what: What; name: string; title: string }[] = [
  { what: 'wiggle', name: 'Which sensors answer?', title: 'Move every joint to and fro' },
  { what: 'zero', name: 'Set the zero position', title: 'Spine and legs straight, against blocks' },
  { what: 'verify', name: 'Has it drifted?', title: 'In the zero position again' },
]

/** The conversation so far; asked for again while it goes on. */
function useCalibration() {
  const { complain } = useStudio()
  const [story, setStory] = useState<Story | null>(null)
  const [begun, setBegun] = useState<What | ''>('')
  const look = () => get<Story>(kAddress).then(setStory, complain)
  useEffect(() => void look(), [])
  const running = story?.running ?? false
  useEffect(() => {
    if (!running) return undefined
    const timer = setInterval(() => void look(), kLook_ms)
    return () => clearInterval(timer)
  }, [running])
  const post = (what: string, body: object) =>
    send<object>('POST', `${kAddress}/${what}`, body).then(look, complain)
  const start = (what: What, setup: object) => {
    setBegun(what)
    return post('start', { ...setup, what })
  }
  return { story, begun, start, go: () => post('go', {}), stop: () => post('stop', {}) }
}

function Talk(props: { story: Story; wiggle: boolean; go: () => void; stop: () => void }) {
  const { story } = props
  const told = story.events.filter((one) => one.words)
  const last = told.at(-1)
  return (
    <>
      <ul class="calibrate-talk small" aria-live="polite">
        {told.slice(-8).map((one, i) => (
          <li key={i} class={one.event === 'ask' ? '' : 'soft'}>
            {one.event === 'ask' ? <b>{sentence(one.words!)}</b> : sentence(one.words!)}
          </li>
        ))}
      </ul>
      {story.running && (
        <div class="row">
          {(last?.event === 'ask' || props.wiggle) && (
            <button class="main" onClick={props.go}>
              {props.wiggle ? 'That was all' : 'It stands so'}
            </button>
          )}
          <button onClick={props.stop}>Stop</button>
        </div>
      )}
      {!story.running && story.exit_code === 0 && told.length > 0 && (
        <p class="good small">Done.</p>
      )}
      {!story.running && story.exit_code !== 0 && story.exit_code !== 130 && (
        <p class="bad small" role="alert">
          {sentence(story.message)}
        </p>
      )}
    </>
  )
}

export function CalibrateCard({ setup, files }: { setup: ArmatureSetup; files: string[] }) {
  const { story, begun, start, go, stop } = useCalibration()
  const [known, setKnown] = useState('')
  const [written, setWritten] = useState('')
  const { description, port, calibration } = setup
  const lacks = !description
    ? 'Name the description first.'
    : port !== kSimulated && !calibration
      ? 'Name the file of the calibration first.'
      : ''
  const blocked = lacks !== '' || (story?.running ?? false)
  const begin = (what: What) =>
    void start(what, { description, port, calibration, ...(what === 'gears' && { known, written }) })
  return (
    <section class="card stack calibrate" aria-label="Calibrate">
      <h2>Calibrate</h2>
      <p class="small soft">
        {lacks || `Once for each puppet: ${calibration || 'the simulated one'}.`}
      </p>
      <div class="row">
        {kWays.map((way) => (
          <button
            key={way.what}
            disabled={blocked}
            title={way.title}
            onClick={() => begin(way.what)}
          >
            {way.name}
          </button>
        ))}
      </div>
      <details>
        <summary>Gear ratios</summary>
        <div class="stack">
          <label class="small">
            File of known angles, lines such as <code>leftKneeBend 30 60 90</code>
            <input
              list="calibrate-known"
              value={known}
              onInput={(event) => setKnown(event.currentTarget.value)}
            />
          </label>
          <label class="small">
            New description with them (may be empty)
            <input
              value={written}
              placeholder="armature/better.txt"
              onInput={(event) => setWritten(event.currentTarget.value)}
            />
          </label>
          <datalist id="calibrate-known">
            {files
              .filter((one) => /\.txt$/i.test(one))
              .map((one) => (
                <option key={one} value={one} />
              ))}
          </datalist>
          <button disabled={blocked || !known} onClick={() => begin('gears')}>
            Find the ratios
          </button>
        </div>
      </details>
      {story && (
        <Talk
          story={story}
          wiggle={begun === 'wiggle'}
          go={() => void go()}
          stop={() => void stop()}
        />
      )}
    </section>
  )
}
