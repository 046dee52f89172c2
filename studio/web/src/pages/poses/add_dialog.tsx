// Photographs that were dropped or chosen: to which pose they go, and what runs again then.
import { useEffect, useRef, useState } from 'preact/hooks'

import { api } from '../../api'
import { Bar } from '../../bar'
import { useStudio } from '../../state'
import { count } from '../../words'
import type { Found, LeftOut } from '../new_project/files'
import { kScan, nameProblem } from '../new_project/rows'
import { groupsOf, isFew, sentOf } from './add_model'
import type { Group, Same, Sent } from './add_model'
import { againWords } from './again_words'
import { useLoaded } from './load'

const kSame: [Same, string][] = [
  ['replace', 'take the place of those (they go to the bin)'],
  ['both', 'keep both'],
  ['skip', 'do not add them'],
]

function problemOf(group: Group, poses: string[]): string {
  if (group.target) return ''
  if (!group.name) return 'Name the new pose.'
  const others = poses.map((name, key) => ({ key, name, photos: [], leftOut: [] }))
  const row = { key: -1, name: group.name, photos: [], leftOut: [] }
  return nameProblem(row, [...others, row])
}

function Files({ files }: { files: LeftOut[] }) {
  if (files.length === 0) return null
  return (
    <details>
      <summary class="warn small">{count(files.length, 'file')} not taken</summary>
      <ul class="small">
        {files.map((one) => (
          <li key={one.path}>
            <code>{one.path}</code> {one.why}
          </li>
        ))}
      </ul>
    </details>
  )
}

/** What becomes of the pose that the photographs go to. */
function Outcome({ group }: { group: Group }) {
  const { project, steps, version } = useStudio()
  const pose = project.poses.find((one) => one.name === group.target)
  const again = useLoaded(
    () => (group.target ? api.again(group.target) : Promise.resolve(null)),
    [group.target, version],
  )
  if (pose) return <p class="small soft">{againWords(again.value, pose.name, steps.steps)}</p>
  if (project.poses.length === 0 || !isFew(group.photos.length)) return null
  return (
    <p class="small soft">
      {project.template} is bent into {count(group.photos.length, 'photograph')}; {kScan} or more
      all round make a scan of their own.
    </p>
  )
}

function GroupFields(props: {
  group: Group
  number: number
  /** a pose that has no photographs yet */
  empty: boolean
  set: (change: Partial<Group>) => void
}) {
  const { group, number, empty, set } = props
  const { project } = useStudio()
  const poses = project.poses.map((pose) => pose.name)
  const problem = problemOf(group, poses)
  const id = `add-${number}`
  return (
    <fieldset class="add-group">
      <legend>
        {empty ? 'Its name' : count(group.photos.length, 'photograph')}
        {group.folder && <span class="soft"> of {group.folder}</span>}
      </legend>
      <div class="row">
        {!empty && <label for={`${id}-to`}>To</label>}
        {!empty && (
        <select
          id={`${id}-to`}
          value={group.target}
          onChange={(event) => set({ target: event.currentTarget.value })}
        >
          {poses.map((pose) => (
            <option key={pose} value={pose}>
              {pose}
            </option>
          ))}
          <option value="">a new pose</option>
        </select>
        )}
        {!group.target && (
          <input
            aria-label="Name of the new pose"
            value={group.name}
            placeholder="wave"
            autocomplete="off"
            spellcheck={false}
            aria-invalid={problem !== ''}
            aria-describedby={problem ? `${id}-problem` : undefined}
            onInput={(event) => set({ name: event.currentTarget.value.normalize('NFC') })}
          />
        )}
      </div>
      {problem && (
        <p class="small warn" id={`${id}-problem`}>
          {problem}
        </p>
      )}
      {!empty && <Outcome group={group} />}
      <Files files={group.leftOut} />
    </fieldset>
  )
}

interface Progress {
  sent: number
  total: number
  failed: { name: string; why: string }[]
}

/** Makes the new poses, then sends one photograph after the other. */
async function sendAll(
  groups: Group[],
  there: Map<string, string[]>,
  same: Same,
  fewOf: (group: Group) => boolean,
  tell: (progress: Progress) => void,
): Promise<Progress> {
  const list: Sent[] = groups.flatMap((one) => sentOf(one, there.get(one.target) ?? [], same))
  const progress: Progress = { sent: 0, total: list.length, failed: [] }
  for (const group of groups)
    if (!group.target) await api.addPose(group.name, fewOf(group))
  for (const { pose, name, file, replaces } of list) {
    tell({ ...progress })
    try {
      await api.addPhotograph(pose, name, file, replaces)
    } catch (error) {
      const why = error instanceof Error ? error.message : String(error)
      progress.failed.push({ name: `${pose}/${name}`, why })
    }
    ++progress.sent
  }
  return progress
}

/** @param found  as it was dropped or chosen; empty: a new pose without photographs yet */
export function AddDialog(props: {
  found: Found[]
  current: string
  close: (pose: string) => void
}) {
  const { project, tell, complain, reload } = useStudio()
  const poses = project.poses.map((pose) => pose.name)
  const dialog = useRef<HTMLDialogElement>(null)
  const [groups, setGroups] = useState<Group[]>(() =>
    props.found.length > 0
      ? groupsOf(props.found, poses, props.current)
      : [{ folder: '', photos: [], leftOut: [], target: '', name: '' }],
  )
  const [same, setSame] = useState<Same>('replace')
  // How a pose will be found that has no photographs yet.
  const [few, setFew] = useState(true)
  const fewOf = (group: Group) =>
    poses.length > 0 && (props.found.length > 0 ? isFew(group.photos.length) : few)
  const [progress, setProgress] = useState<Progress | null>(null)
  const there = useLoaded(
    async () => new Map(await Promise.all(poses.map(async (pose) => namesOf(pose)))),
    [poses.join()],
  )
  useEffect(() => dialog.current!.showModal(), [])
  const used = groups.filter((one) => one.photos.length > 0 || props.found.length === 0)
  const photographs = used.reduce((sum, one) => sum + one.photos.length, 0)
  const conflicts = used.flatMap((one) => {
    const names = new Set(there.value?.get(one.target) ?? [])
    return one.photos.filter((photo) => names.has(photo.name))
  })
  const names = used.filter((one) => !one.target).map((one) => one.name.toLowerCase())
  const twice = new Set(names).size < names.length
  const ready =
    used.length > 0 && there.value !== null && !twice && used.every((one) => !problemOf(one, poses))
  const add = async () => {
    try {
      const done = await sendAll(used, there.value!, same, fewOf, setProgress)
      await reload()
      if (done.failed.length > 0) return setProgress(done)
      tell(photographs > 0 ? `Added: ${count(done.total, 'photograph')}.` : 'The pose is made.')
      props.close(used[0].target || used[0].name)
    } catch (error) {
      complain(error)
      await reload()
      props.close('')
    }
  }
  const sending = progress !== null && progress.sent < progress.total
  return (
    <dialog
      ref={dialog}
      class="photo-dialog"
      aria-labelledby="add-title"
      onClose={() => props.close('')}
    >
      <form
        class="stack"
        onSubmit={(event) => {
          event.preventDefault()
          if (ready && !progress) void add()
        }}
      >
        <h2 id="add-title">{photographs > 0 ? 'Add photographs' : 'A new pose'}</h2>
        {props.found.length > 0 && photographs === 0 && (
          <p>No photograph is among them that can be read.</p>
        )}
        {groups.map((group, i) => (
          <GroupFields
            key={group.folder}
            group={group}
            number={i}
            empty={props.found.length === 0}
            set={(change) =>
              setGroups((old) => old.map((one) => (one === group ? { ...one, ...change } : one)))
            }
          />
        ))}
        {props.found.length === 0 && poses.length > 0 && (
          <fieldset class="add-group">
            <legend>Its photographs</legend>
            <label class="row">
              <input type="radio" name="few" checked={few} onChange={() => setFew(true)} />
              six or so: {project.template} is bent into them
            </label>
            <label class="row">
              <input type="radio" name="few" checked={!few} onChange={() => setFew(false)} />
              {kScan} or more, all round: a scan of its own
            </label>
          </fieldset>
        )}
        {twice && <p class="small warn">Two new poses have one name.</p>}
        {conflicts.length > 0 && !progress && (
          <fieldset class="add-group">
            <legend>{count(conflicts.length, 'name')} there already</legend>
            {kSame.map(([what, words]) => (
              <label key={what} class="row">
                <input
                  type="radio"
                  name="same"
                  checked={same === what}
                  onChange={() => setSame(what)}
                />
                {words}
              </label>
            ))}
          </fieldset>
        )}
        {sending && (
          <Bar label="Photographs sent" share={progress.sent / Math.max(1, progress.total)} />
        )}
        {progress && progress.failed.length > 0 && !sending && (
          <div role="alert" class="stack">
            <p class="warn">{count(progress.failed.length, 'photograph')} not taken:</p>
            <ul class="small">
              {progress.failed.map((one) => (
                <li key={one.name}>
                  <code>{one.name}</code> {one.why}
                </li>
              ))}
            </ul>
          </div>
        )}
        <div class="row">
          {!progress && (
            <button class="main" disabled={!ready}>
              {photographs > 0 ? `Add ${count(photographs, 'photograph')}` : 'Make the pose'}
            </button>
          )}
          <button type="button" class="quiet" disabled={sending} onClick={() => props.close('')}>
            {progress ? 'Close' : 'Cancel'}
          </button>
        </div>
      </form>
    </dialog>
  )
}

async function namesOf(pose: string): Promise<[string, string[]]> {
  return [pose, (await api.photos(pose)).map((one) => one.name)]
}
