// Before a session: which pose, camera and turntable, and how many photographs.
import { useState } from 'preact/hooks'
import type { ComponentChildren } from 'preact'

import type { ShootSetup, ShootStory } from '../../api'
import { useStudio } from '../../state'
import { count } from '../../words'
import {
  draftOf,
  kFirstDraft,
  kMore,
  offersSix,
  problemsOf,
  setupOf,
  summaryOf,
  withAmount,
  withPlan,
} from './setup'
import type { Amount, CameraKind, Draft, TableKind } from './setup'

const kCameras: [CameraKind, string, string][] = [
  ['gphoto2', 'On a cable', 'Focus, exposure and white balance on manual.'],
  ['folder', 'A watched folder', 'Another program fills it: each new photograph is the next one.'],
  ['simulated', 'Simulated', 'A drawn clay figure, to try all this without a camera.'],
]
const kTables: [TableKind, string, string][] = [
  ['none', 'Turned by hand', 'The page says the angle; Space when the table stands there.'],
  ['grbl', 'GRBL on a cable', 'An axis of a GRBL controller turns the table.'],
  ['steps', 'Own firmware on a cable', 'The line protocol of docs/shoot.md.'],
  ['simulated', 'Simulated', 'Turns in no time.'],
]
const kFlips = ['not at all', 'laid on one side', 'on two sides', 'on three sides']

function Field(props: {
  id: string
  label: string
  hint?: string
  problem?: string
  children: ComponentChildren
}) {
  return (
    <div class="shoot-field">
      <label for={props.id}>{props.label}</label>
      {props.children}
      {props.problem ? (
        <p class="small bad" id={`${props.id}-hint`}>
          {props.problem}
        </p>
      ) : (
        props.hint && (
          <p class="small soft" id={`${props.id}-hint`}>
            {props.hint}
          </p>
        )
      )}
    </div>
  )
}

interface FieldProps {
  draft: Draft
  set: (change: Partial<Draft>) => void
  /** only what has been tried, so that an empty form does not complain */
  problems: Partial<Record<keyof Draft, string>>
}

function PoseField({ draft, set, problems }: FieldProps) {
  const { project } = useStudio()
  const known = project.poses.find((one) => one.name === draft.pose)
  const hint = known
    ? `${count(known.photographs, 'photograph')} there: it goes on with what is missing.`
    : 'A new name makes a new pose.'
  return (
    <Field id="shoot-pose" label="Pose" hint={hint} problem={problems.pose}>
      <input
        id="shoot-pose"
        list="shoot-poses"
        value={draft.pose}
        autocomplete="off"
        spellcheck={false}
        placeholder="standing"
        aria-describedby="shoot-pose-hint"
        aria-invalid={problems.pose !== undefined}
        onInput={(event) => set({ pose: event.currentTarget.value.normalize('NFC') })}
      />
      <datalist id="shoot-poses">
        {project.poses.map((one) => (
          <option key={one.name} value={one.name} />
        ))}
      </datalist>
    </Field>
  )
}

function Choices<K extends string>(props: {
  id: string
  label: string
  all: [K, string, string][]
  value: K
  choose: (value: K) => void
}) {
  const chosen = props.all.find(([kind]) => kind === props.value)
  return (
    <Field id={props.id} label={props.label} hint={chosen?.[2]}>
      <select
        id={props.id}
        value={props.value}
        aria-describedby={`${props.id}-hint`}
        onChange={(event) => props.choose(event.currentTarget.value as K)}
      >
        {props.all.map(([kind, words]) => (
          <option key={kind} value={kind}>
            {words}
          </option>
        ))}
      </select>
    </Field>
  )
}

function FolderField({ draft, set, problems }: FieldProps) {
  if (draft.camera === 'gphoto2') return null
  const watched = draft.camera === 'folder'
  return (
    <Field
      id="shoot-folder"
      label={watched ? 'Folder' : 'Photographs to take, if not the drawn ones'}
      problem={problems.folder}
    >
      <input
        id="shoot-folder"
        value={draft.folder}
        autocomplete="off"
        spellcheck={false}
        placeholder={watched ? '/home/me/tethered' : 'a folder'}
        aria-invalid={problems.folder !== undefined}
        aria-describedby={problems.folder ? 'shoot-folder-hint' : undefined}
        onInput={(event) => set({ folder: event.currentTarget.value })}
      />
    </Field>
  )
}

function PortField({ draft, set, problems, ports }: FieldProps & { ports: ShootStory['ports'] }) {
  if (draft.table !== 'grbl' && draft.table !== 'steps') return null
  const hint = ports.length > 0 ? '' : 'Nothing is plugged in that looks like a turntable.'
  return (
    <Field id="shoot-port" label="Port" hint={hint} problem={problems.port}>
      <input
        id="shoot-port"
        list="shoot-ports"
        value={draft.port}
        autocomplete="off"
        spellcheck={false}
        placeholder="/dev/ttyUSB0"
        aria-invalid={problems.port !== undefined}
        aria-describedby="shoot-port-hint"
        onInput={(event) => set({ port: event.currentTarget.value })}
      />
      <datalist id="shoot-ports">
        {ports.map((one) => (
          <option key={one.path} value={one.path}>
            {one.name}
          </option>
        ))}
      </datalist>
    </Field>
  )
}

function PlanFields({ draft, set, problems, fixed }: FieldProps & { fixed: boolean }) {
  return (
    <>
      <div class="shoot-two">
        <Field id="shoot-rings" label="Rings, heights in °" problem={problems.rings}>
          <input
            id="shoot-rings"
            class="number"
            disabled={fixed}
            value={draft.rings}
            autocomplete="off"
            aria-invalid={problems.rings !== undefined}
            onInput={(event) => set({ rings: event.currentTarget.value })}
          />
        </Field>
        <Field id="shoot-angles" label="Angles in a ring" problem={problems.angles}>
          <input
            id="shoot-angles"
            class="number"
            disabled={fixed}
            inputmode="numeric"
            value={draft.angles}
            autocomplete="off"
            aria-invalid={problems.angles !== undefined}
            onInput={(event) => set({ angles: event.currentTarget.value })}
          />
        </Field>
      </div>
      <Field
        id="shoot-flips"
        label="The underside"
        hint={fixed ? `${draft.pose} was begun with these rings and angles.` : ''}
      >
        <select
          id="shoot-flips"
          disabled={fixed}
          value={draft.flips}
          onChange={(event) => set({ flips: Number(event.currentTarget.value) })}
        >
          {kFlips.map((words, flips) => (
            <option key={flips} value={flips}>
              {words}
            </option>
          ))}
        </select>
      </Field>
    </>
  )
}

/** What few need: it stays folded away. */
function MoreFields({ draft, set }: FieldProps) {
  const fields = kMore.filter((one) => !one.table || one.table === draft.table)
  return (
    <details>
      <summary>More</summary>
      <div class="stack">
        {fields.map(({ flag, label, usual }) => (
          <Field key={flag} id={`shoot-${flag}`} label={label}>
            <input
              id={`shoot-${flag}`}
              value={draft.more?.[flag] ?? ''}
              placeholder={usual}
              autocomplete="off"
              onInput={(event) =>
                set({ more: { ...draft.more, [flag]: event.currentTarget.value } })
              }
            />
          </Field>
        ))}
      </div>
    </details>
  )
}

/** Six photographs or a ring, and when which is better. */
export function AmountChoice(props: {
  amount: Amount
  template: string
  choose: (amount: Amount) => void
}) {
  const { amount, template, choose } = props
  const button = (what: Amount, words: string) => (
    <button type="button" aria-pressed={amount === what} onClick={() => choose(what)}>
      {words}
    </button>
  )
  return (
    <div class="shoot-field">
      <div class="choice" role="group" aria-label="How many photographs">
        {button('six', 'Six photographs')}
        {button('ring', 'A full ring')}
      </div>
      <p class="small soft">
        {amount === 'ring' ? `A scan of its own. ` : `${template} is bent into six, all round. `}
        {ringIsBetter(template)}
      </p>
    </div>
  )
}

export const ringIsBetter = (template: string) =>
  `A full ring is better where the pose shows places that ${template} hides (an open mouth, a ` +
  'hand off the body), or where the figure itself was changed.'

export interface SetupForm {
  draft: Draft
  /** null: nothing is to be chosen */
  amount: Amount | null
  chooseAmount: (amount: Amount) => void
  /** the pose has its plan already */
  fixed: boolean
  set: (change: Partial<Draft>) => void
  /** what is wrong, of fields that were touched or after a try to begin */
  problems: Partial<Record<keyof Draft, string>>
  /** the setup, or null: something is missing, and shown by now */
  ready: () => ShootSetup | null
}

/** @param pose  of the session that has just ended, or '' */
export function useSetup(story: ShootStory, pose: string): SetupForm {
  const { project } = useStudio()
  const [typed, setDraft] = useState<Draft>(() => {
    const last = story.setup ? draftOf(story.setup) : kFirstDraft
    return { ...last, pose: pose || last.pose || (project.poses[0]?.name ?? '') }
  })
  const [chosen, choose] = useState<Amount>('six')
  const offered = offersSix(typed.pose, project.poses, story.plans)
  const amount = offered ? chosen : 'own'
  const draft = withPlan(
    withAmount(typed, amount, story.plans[project.template]),
    story.plans,
  )
  const [touched, setTouched] = useState<Set<string>>(new Set())
  const all = problemsOf(draft)
  const fixed = draft.pose in story.plans
  const shown = Object.entries(all).filter(([field]) => touched.has(field))
  return {
    draft,
    amount: offered ? amount : null,
    chooseAmount: choose,
    fixed,
    problems: Object.fromEntries(shown),
    set: (change) => {
      const plan = 'rings' in change || 'angles' in change || 'flips' in change
      // What was proposed stays where another field of it is typed.
      const { rings, angles, flips } = draft
      if (plan) choose('own')
      setDraft((old) => ({ ...old, ...(plan && { rings, angles, flips }), ...change }))
      setTouched((old) => new Set([...old, ...Object.keys(change)]))
    },
    ready: () => {
      setTouched(new Set(Object.keys(draft)))
      return Object.keys(all).length > 0 ? null : setupOf(draft)
    },
  }
}

export function SetupFields({ form, ports }: { form: SetupForm; ports: ShootStory['ports'] }) {
  const { project } = useStudio()
  const { draft, set, problems } = form
  const fields = { draft, set, problems }
  return (
    <>
      <PoseField {...fields} />
      <Choices
        id="shoot-camera"
        label="Camera"
        all={kCameras}
        value={draft.camera}
        choose={(camera) => set({ camera })}
      />
      <FolderField {...fields} />
      <Choices
        id="shoot-table"
        label="Turntable"
        all={kTables}
        value={draft.table}
        choose={(table) => set({ table })}
      />
      <PortField {...fields} ports={ports} />
      {form.amount && (
        <AmountChoice
          amount={form.amount}
          template={project.template}
          choose={form.chooseAmount}
        />
      )}
      <PlanFields {...fields} fixed={form.fixed} />
      <MoreFields {...fields} />
      <p class="small number" aria-live="polite">
        {summaryOf(draft)}
      </p>
    </>
  )
}
