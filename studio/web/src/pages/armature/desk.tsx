// A session at work: the character over its plate, what is recorded, sensors and chains.
import { useEffect, useMemo, useRef, useState } from 'preact/hooks'

import { useKeys } from '../../keys'
import { useStudio } from '../../state'
import { count, sentence } from '../../words'
import { Act } from '../shoot/controls'
import { armatureApi } from './armature_api'
import type { ArmaturePose, ArmatureSetup } from './armature_api'
import { BakeChoice } from './bake_choice'
import { PuppetStage } from './puppet_stage'
import type { PuppetView } from './puppet_view'
import { Readings } from './readings'
import { addressOfTake } from './setup'
import { plateOf } from './sitting'
import type { Sitting } from './sitting'
import { useCharacter, useFrames } from './use_character'
import type { Loaded } from './use_character'
import { usePoses } from './use_sitting'
import type { AtPuppet } from './use_sitting'

/** Readings on the page are text: ten a second are enough. */
const kReadEvery_ms = 100

interface DeskProps {
  at: AtPuppet
  sitting: Sitting
  setup: ArmatureSetup
}

export function Desk(props: DeskProps) {
  const loaded = useCharacter(props.sitting.ready ? props.setup : null)
  if (!loaded)
    return (
      <main class="empty" role="status">
        Looks for the puppet, and finds out how its bones move the character …
        <button onClick={() => void armatureApi.interrupt()}>Stop</button>
      </main>
    )
  return <ReadyDesk {...props} loaded={loaded} />
}

/** Recorded frames as a flipbook: the frame that is shown, or null. */
function useFlipbook(frames: number, rate: number) {
  const [frame, setFrame] = useState<number | null>(null)
  const playing = frame !== null
  useEffect(() => {
    if (!playing || frames === 0) return undefined
    const timer = setInterval(
      () => setFrame((old) => (old === null ? null : (old + 1) % frames)),
      1000 / rate,
    )
    return () => clearInterval(timer)
  }, [playing, frames, rate])
  const toggle = () => setFrame((old) => (old === null && frames > 0 ? 0 : null))
  return { frame, toggle, stop: () => setFrame(null) }
}

function ReadyDesk({ at, sitting, setup, loaded }: DeskProps & { loaded: Loaded }) {
  const { complain } = useStudio()
  const { view } = loaded
  const frames = useFrames(view.bones, sitting.frames, sitting.changes)
  const [rate, setRate] = useState(sitting.fps / sitting.step)
  const [onion, setOnion] = useState(2)
  const [free, setFree] = useState(false)
  const [set, setSet] = useState(true)
  const [between, setBetween] = useState('hold')
  const [reading, setReading] = useState<ArmaturePose | null>(null)
  const live = useRef<ArmaturePose | null>(null)
  const puppet = useRef<PuppetView | null>(null)
  const readAt = useRef(0)
  const [session] = useState(at.story?.number ?? 0)
  const flip = useFlipbook(frames.length, rate)
  const tell = (command: string, more: { frame?: number; joint?: string } = {}) =>
    void armatureApi.tell({ command, ...more }).catch(complain)

  usePoses(true, (pose) => {
    live.current = pose
    if (flip.frame === null) puppet.current?.setPose(pose.bones)
    const now = performance.now()
    if (now - readAt.current < kReadEvery_ms) return
    readAt.current = now
    setReading(pose)
  })
  const shown = flip.frame
  useEffect(() => {
    const bones = shown !== null ? frames[shown] : live.current?.bones
    if (bones) puppet.current?.setPose(bones)
  }, [shown, frames])
  const ghosts = useMemo(
    () => (shown === null ? frames.slice(Math.max(0, sitting.at - onion), sitting.at) : []),
    [frames, sitting.at, onion, shown],
  )
  useEffect(() => puppet.current?.setGhosts(ghosts), [ghosts])
  useEffect(() => puppet.current?.setFree(free), [free])
  useEffect(() => puppet.current?.showSet(set), [set])

  const acts = {
    record: () => {
      flip.stop()
      tell('record')
    },
    back: () => sitting.at > 0 && tell('back'),
    next: () => sitting.at < sitting.frames && tell('next'),
    plate: () => tell('next-plate'),
    bake: () => {
      at.setBaking(true)
      armatureApi.bake(between).catch((error: unknown) => {
        at.setBaking(false)
        complain(error)
      })
    },
  }
  useKeys({
    ' ': acts.record,
    Enter: acts.record,
    Backspace: acts.back,
    ArrowLeft: acts.back,
    ArrowRight: acts.next,
    p: acts.plate,
    f: flip.toggle,
    v: () => setFree(!free),
    Escape: flip.stop,
  })
  const plate = shown === null ? sitting.plate : plateOf(shown, sitting.step, view.plate_count)
  return (
    <main class="page shoot-page armature-page">
      <h1 class="hidden">Armature: {setup.take}</h1>
      <aside class="side" aria-label="Session">
        <div class="row spread">
          <h2>{setup.take}</h2>
          <span class="number">{count(sitting.frames, 'frame')}</span>
        </div>
        <p class="small soft" role="status">
          {shown === null
            ? `Frame ${sitting.at} is next, plate ${sitting.plate + 1} of ${view.plate_count}`
            : `Flipbook: frame ${shown}`}
        </p>
        <div class="shoot-buttons">
          <Act main keys="Space" act={acts.record}>
            {sitting.at < sitting.frames ? `Record ${sitting.at} again` : 'Record'}
          </Act>
          <Act keys="⌫" disabled={sitting.at === 0} act={acts.back}>
            Back
          </Act>
          <Act keys="→" disabled={sitting.at >= sitting.frames} act={acts.next}>
            Next
          </Act>
          <Act keys="P" disabled={view.plate_count < 2} act={acts.plate}>
            Next plate
          </Act>
          <Forget sitting={sitting} cut={() => tell('cut')} />
          <Act keys="F" disabled={frames.length === 0} act={flip.toggle}>
            {shown === null ? 'Flipbook' : 'Back to the puppet'}
          </Act>
        </div>
        <Looks
          {...{ rate, setRate, onion, setOnion, free, setFree, set, setSet }}
          hasSet={setup.set !== ''}
        />
        <BakeChoice
          {...{ between, setBetween }}
          take={setup.take}
          baking={at.baking}
          disabled={sitting.frames === 0}
          bake={acts.bake}
        />
        {sitting.frames > 0 && (
          <a class="button" href={addressOfTake(setup.take)}>
            Edit the take
          </a>
        )}
        <Act act={() => tell('end')}>End</Act>
      </aside>
      <div class="work">
        <PuppetStage
          {...{ loaded, plate, free }}
          plateUrl={(index) => armatureApi.plateUrl(index, session)}
          puppet={puppet}
        />
        <div class="shoot-foot">
          <div class="words">
            <Words sitting={sitting} reading={reading} simulated={setup.port === 'simulated'} />
          </div>
        </div>
      </div>
      <Readings
        view={view}
        sitting={sitting}
        reading={reading}
        zero={(joint) => tell('zero', { joint })}
      />
    </main>
  )
}

/** The frame that is next and all after it: asked twice. */
function Forget({ sitting, cut }: { sitting: Sitting; cut: () => void }) {
  const [asked, setAsked] = useState(-1)
  const there = sitting.at < sitting.frames
  return (
    <Act
      disabled={!there}
      act={() => {
        if (asked === sitting.at) cut()
        setAsked(asked === sitting.at ? -1 : sitting.at)
      }}
    >
      {there && asked === sitting.at ? `Forget ${sitting.at} on?` : 'Forget'}
    </Act>
  )
}

function Looks(props: {
  rate: number
  setRate: (rate: number) => void
  onion: number
  setOnion: (onion: number) => void
  free: boolean
  setFree: (free: boolean) => void
  set: boolean
  setSet: (set: boolean) => void
  hasSet: boolean
}) {
  const rates = [...new Set([12, 24, props.rate])].sort((a, b) => a - b)
  return (
    <div class="stack" style="gap:8px">
      <div class="row spread">
        <label for="armature-onion">Onion skin, frames</label>
        <input
          id="armature-onion"
          type="range"
          min={0}
          max={5}
          value={props.onion}
          onInput={(event) => props.setOnion(Number(event.currentTarget.value))}
        />
        <span class="number">{props.onion}</span>
      </div>
      <div class="row spread">
        <label for="armature-rate">Flipbook, frames a second</label>
        <select
          id="armature-rate"
          value={props.rate}
          onChange={(event) => props.setRate(Number(event.currentTarget.value))}
        >
          {rates.map((one) => (
            <option key={one} value={one}>
              {one}
            </option>
          ))}
        </select>
      </div>
      <div class="row">
        <button aria-pressed={props.free} onClick={() => props.setFree(!props.free)}>
          From the side <kbd>V</kbd>
        </button>
        {props.hasSet && (
          <button aria-pressed={props.set} onClick={() => props.setSet(!props.set)}>
            Set
          </button>
        )}
      </div>
    </div>
  )
}

function Words(props: { sitting: Sitting; reading: ArmaturePose | null; simulated: boolean }) {
  const { sitting, reading } = props
  const { connected } = useStudio()
  const away = { words: 'The studio does not answer', do: 'Start it again in this folder.' }
  const silent = reading && !reading.fresh ? { words: 'The board is away', do: '' } : null
  const box = connected ? (sitting.box ?? silent) : away
  if (box)
    return (
      <div class="shoot-say fault" role="alert">
        <p>
          <b>{sentence(box.words)}</b>
        </p>
        <p>{sentence(box.do)}</p>
        <p class="small soft">Nothing that was recorded is lost.</p>
      </div>
    )
  const said = sitting.refused || (sitting.waiting && `The frame waits: ${sitting.waiting}`)
  if (said)
    return (
      <div class="shoot-say ask" role="status">
        <p>
          <b>{sentence(said)}</b>
        </p>
      </div>
    )
  return (
    <>
      {sitting.warning && <p class="warn">{sentence(sitting.warning)}</p>}
      <p class="soft">
        {props.simulated
          ? 'The simulated puppet takes its pose for each frame. Space records it.'
          : 'Pose the puppet. Space records it as soon as it rests.'}
      </p>
    </>
  )
}
