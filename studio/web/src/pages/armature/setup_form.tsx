// Before a session: the puppet's files, the controller, the take.
import type { ComponentChildren } from 'preact'

import type { ArmatureSetup, ArmatureStory } from './armature_api'
import { kNeeded, kOptional, kSimulated } from './setup'
import type { FileField } from './setup'

type Problems = Partial<Record<keyof ArmatureSetup, string>>

export interface FormProps {
  setup: ArmatureSetup
  set: (change: Partial<ArmatureSetup>) => void
  /** only what has been tried, so that an empty form does not complain */
  problems: Problems
  story: ArmatureStory
}

function Field(props: {
  id: string
  label: string
  hint?: string
  problem?: string
  children: ComponentChildren
}) {
  const words = props.problem ?? props.hint
  return (
    <div class="shoot-field">
      <label for={props.id}>{props.label}</label>
      {props.children}
      {words && (
        <p class={`small ${props.problem ? 'bad' : 'soft'}`} id={`${props.id}-hint`}>
          {words}
        </p>
      )}
    </div>
  )
}

function TextField(
  props: FormProps & {
    name: keyof ArmatureSetup & string
    label: string
    hint?: string
    offers: string[]
    placeholder?: string
  },
) {
  const { name, offers } = props
  const id = `armature-${name}`
  const problem = props.problems[name]
  return (
    <Field id={id} label={props.label} hint={props.hint} problem={problem}>
      <input
        id={id}
        list={`${id}-offers`}
        value={String(props.setup[name])}
        autocomplete="off"
        spellcheck={false}
        placeholder={props.placeholder}
        aria-invalid={problem !== undefined}
        aria-describedby={problem || props.hint ? `${id}-hint` : undefined}
        onInput={(event) => props.set({ [name]: event.currentTarget.value.normalize('NFC') })}
      />
      <datalist id={`${id}-offers`}>
        {offers.map((one) => (
          <option key={one} value={one} />
        ))}
      </datalist>
    </Field>
  )
}

const offersOf = (field: FileField, files: string[]) => files.filter((one) => field.kinds.test(one))

export function FileFields(props: FormProps & { fields: FileField[] }) {
  return (
    <>
      {props.fields.map((field) => (
        <TextField
          key={field.name}
          {...props}
          name={field.name}
          label={field.label}
          hint={field.hint}
          offers={offersOf(field, props.story.files)}
        />
      ))}
    </>
  )
}

/** Most skeletons of other programs have y up. */
export function UpFields({ setup, set }: Pick<FormProps, 'setup' | 'set'>) {
  const fields = [
    { name: 'armature_up', label: 'Up in the description' },
    { name: 'skeleton_up', label: 'Up in the skeleton' },
  ] as const
  return (
    <div class="shoot-two">
      {fields.map(({ name, label }) => (
        <Field key={name} id={`armature-${name}`} label={label}>
          <select
            id={`armature-${name}`}
            value={setup[name]}
            onChange={(event) => set({ [name]: event.currentTarget.value })}
          >
            <option value="z">z</option>
            <option value="y">y</option>
          </select>
        </Field>
      ))}
    </div>
  )
}

export function ControllerFields(props: FormProps) {
  const { setup, set, story } = props
  const simulated = setup.port === kSimulated
  return (
    <>
      <Field
        id="armature-controller"
        label="Controller"
        hint={simulated ? 'A puppet without hardware poses itself for each frame.' : ''}
      >
        <select
          id="armature-controller"
          value={simulated ? kSimulated : 'board'}
          aria-describedby={simulated ? 'armature-controller-hint' : undefined}
          onChange={(event) =>
            set({
              port:
                event.currentTarget.value === kSimulated
                  ? kSimulated
                  : (story.ports[0]?.path ?? '/dev/ttyACM0'),
            })
          }
        >
          <option value="board">A board on a cable</option>
          <option value={kSimulated}>Simulated</option>
        </select>
      </Field>
      {!simulated && (
        <>
          <TextField
            {...props}
            name="port"
            label="Port"
            hint={story.ports.length > 0 ? '' : 'Nothing is plugged in that looks like a board.'}
            offers={story.ports.map((one) => one.path)}
          />
          <TextField
            {...props}
            name="calibration"
            label="Calibration"
            hint="Calibrate, at the right, makes it."
            offers={story.files.filter((one) => /\.json$/.test(one))}
          />
        </>
      )}
    </>
  )
}

export function SetupFields(props: FormProps) {
  const { setup, set, story } = props
  const known = story.takes.includes(setup.take)
  return (
    <>
      <TextField
        {...props}
        name="take"
        label="Take"
        hint={known ? 'It goes on where it was.' : 'A new name begins a new recording.'}
        offers={story.takes}
      />
      <ControllerFields {...props} />
      <FileFields {...props} fields={kNeeded} />
      <div class="shoot-two">
        <Field id="armature-step" label="Recorded on">
          <select
            id="armature-step"
            value={setup.step}
            onChange={(event) => set({ step: Number(event.currentTarget.value) })}
          >
            {['ones', 'twos', 'threes', 'fours'].map((words, i) => (
              <option key={words} value={i + 1}>
                {words}
              </option>
            ))}
          </select>
        </Field>
        <Field id="armature-fps" label="Frames a second" problem={props.problems.fps}>
          <input
            id="armature-fps"
            class="number"
            inputmode="numeric"
            value={setup.fps}
            aria-invalid={props.problems.fps !== undefined}
            onInput={(event) => set({ fps: Number(event.currentTarget.value) })}
          />
        </Field>
      </div>
      <details class="armature-more" open={kOptional.some((one) => setup[one.name] !== '')}>
        <summary>Character, plate and set</summary>
        <div class="stack">
          <FileFields {...props} fields={kOptional} />
          <UpFields {...props} />
        </div>
      </details>
    </>
  )
}
