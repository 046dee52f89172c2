// The puppet as an input device: set up, then pose it, frame after frame, over the plate. The
// session is `keypose armature live`.
import { useEffect, useState } from 'preact/hooks'

import { useStudio } from '../state'
import { SendFiles } from '../uploads/send_files'
import { sentence } from '../words'
import { armatureApi } from './armature/armature_api'
import type { ArmatureSetup, ArmatureStory } from './armature/armature_api'
import './shoot/shoot.css'
import './armature/armature.css'
import { CalibrateCard } from './armature/calibrate_card'
import { Desk } from './armature/desk'
import { kFirstSetup, kSimulated, problemsOf, takeOfAddress } from './armature/setup'
import { SetupFields } from './armature/setup_form'
import type { Sitting } from './armature/sitting'
import { useSitting } from './armature/use_sitting'
import { TakeList, TakePage } from './take'
import { nextName } from './take/take_model'

/** The take that the address names, or '' for the puppet itself. */
function useTakeOfAddress(): string {
  const [take, setTake] = useState(takeOfAddress(location.hash))
  useEffect(() => {
    const changed = () => setTake(takeOfAddress(location.hash))
    addEventListener('hashchange', changed)
    return () => removeEventListener('hashchange', changed)
  }, [])
  return take
}

export function ArmaturePage() {
  const take = useTakeOfAddress()
  return take ? <TakePage key={take} name={take} /> : <PuppetPage />
}

function PuppetPage() {
  const at = useSitting()
  const { sitting, story, load } = at
  if (!sitting || !story) return <main class="empty">Looks for a session …</main>
  // A page that was open when the session began asks for its set-up again.
  if (sitting.running && story.setup) return <Desk at={at} sitting={sitting} setup={story.setup} />
  return <Begin key={story.number} sitting={sitting} story={story} load={load} />
}

function toFirstProblem() {
  document.querySelector<HTMLElement>('.shoot-page [aria-invalid="true"]')?.focus()
}

function Begin(props: { sitting: Sitting; story: ArmatureStory; load: () => Promise<void> }) {
  const { sitting, story, load } = props
  const { complain } = useStudio()
  const [setup, setSetup] = useState<ArmatureSetup>({ ...kFirstSetup, ...story.setup })
  const [tried, setTried] = useState(false)
  const [busy, setBusy] = useState(false)
  const problems = problemsOf(setup)
  const set = (change: Partial<ArmatureSetup>) => setSetup((old) => ({ ...old, ...change }))
  const doing = async (act: () => Promise<unknown>) => {
    setBusy(true)
    await act().catch(complain)
    setBusy(false)
  }
  const begin = (now: ArmatureSetup) =>
    doing(async () => {
      setTried(true)
      if (Object.keys(problemsOf(now)).length > 0) return setTimeout(toFirstProblem)
      await armatureApi.start(now)
      return load()
    })
  const known = story.takes.includes(setup.take)
  // Frames of a simulated puppet do not go on behind those of a real one.
  const simulated = (): ArmatureSetup => {
    const names = [...story.takes, ...story.edited]
    const take = known ? nextName(setup.take, names) : setup.take
    return { ...setup, port: kSimulated, take }
  }
  const example = () => doing(async () => setSetup(await armatureApi.example()))
  return (
    <main class="page shoot-page begin">
      <h1 class="hidden">Armature</h1>
      <aside class="side" aria-label="Set-up">
        <form
          class="stack"
          onSubmit={(event) => {
            event.preventDefault()
            void begin(setup)
          }}
        >
          <SetupFields setup={setup} set={set} problems={tried ? problems : {}} story={story} />
          <button class="main" disabled={busy}>
            {known ? `Go on with ${setup.take}` : 'Begin'}
          </button>
        </form>
      </aside>
      <div class="work">
        <div class="shoot-begin">
          {sitting.failure && (
            <div class="shoot-say fault" role="alert">
              <p>
                <b>The session could not go on.</b>
              </p>
              <p>{sentence(sitting.failure)}</p>
              <p class="small soft">All frames that were recorded are kept.</p>
              {setup.port !== kSimulated && (
                <div class="row">
                  <button
                    disabled={busy}
                    onClick={() => {
                      setSetup(simulated())
                      void begin(simulated())
                    }}
                  >
                    Try it with a simulated puppet
                  </button>
                  {known && <span class="small soft">as {simulated().take}</span>}
                </div>
              )}
            </div>
          )}
          {setup.description && <CalibrateCard setup={setup} files={story.files} />}
          <TakeList recorded={story.takes} edited={story.edited} />
          <Advice />
          <SendFiles
            place="armature"
            words="Drop the puppet’s files; they go into the project’s folder ‘armature’."
            done={() => void load()}
          />
          {!setup.description && (
            <div class="shoot-say" role="status">
              <p>
                <b>No puppet at hand?</b> A theropod with 74 sensors, a body, a plate and a set.
              </p>
              <div class="row">
                <button disabled={busy} onClick={() => void example()}>
                  Use the example
                </button>
              </div>
            </div>
          )}
        </div>
      </div>
    </main>
  )
}

function Advice() {
  const steps = [
    'Send the puppet’s description and chain file, with skeleton, character, plate, its camera ' +
      'and the set, as far as there are any; name them at the left.',
    'Calibrate once, with the puppet in its zero position.',
    'Begin. Pose the puppet: the character follows, over the plate, with the frames before as ' +
      'onion skin.',
    'Space records the frame and goes to the next; F shows what is there as a flipbook.',
  ]
  return (
    <ol class="shoot-advice">
      {steps.map((words) => (
        <li key={words}>{words}</li>
      ))}
    </ol>
  )
}
