// The list of poses: chosen, renamed, sorted, deleted, made the template.
import { useEffect, useRef, useState } from 'preact/hooks'

import { api } from '../../api'
import type { Pose } from '../../api'
import { Menu, placeOfMenu } from '../../menu'
import type { MenuItem, MenuPlace } from '../../menu'
import { useStudio } from '../../state'
import { count } from '../../words'
import { kScan, nameProblem } from '../new_project/rows'
import { isFromMesh } from './tabs'

function RenameField(props: { pose: string; done: (name: string) => void; cancel: () => void }) {
  const { project } = useStudio()
  const [name, setName] = useState(props.pose)
  const field = useRef<HTMLInputElement>(null)
  useEffect(() => {
    field.current!.focus()
    field.current!.select()
  }, [])
  const others = project.poses
    .filter((one) => one.name !== props.pose)
    .map((one, key) => ({ key, name: one.name, photos: [], leftOut: [] }))
  const row = { key: -1, name, photos: [], leftOut: [] }
  const problem = name ? nameProblem(row, [...others, row]) : 'Name the pose.'
  return (
    <form
      class="rename"
      onSubmit={(event) => {
        event.preventDefault()
        if (!problem) props.done(name)
      }}
    >
      <input
        ref={field}
        aria-label={`New name of ${props.pose}`}
        value={name}
        autocomplete="off"
        spellcheck={false}
        aria-invalid={problem !== ''}
        onInput={(event) => setName(event.currentTarget.value.normalize('NFC'))}
        onKeyDown={(event) => event.key === 'Escape' && props.cancel()}
      />
      <button class="main" disabled={problem !== ''}>
        Rename
      </button>
      <p class={`small ${problem ? 'warn' : 'soft'}`} role="status">
        {problem || 'Its photographs, landmarks, masks and keys go with it; nothing is made anew.'}
      </p>
    </form>
  )
}

interface PoseActs {
  rename: (pose: string) => void
  move: (pose: string, by: number) => void
  remove: (pose: Pose) => void
  template: (pose: string) => void
  method: (pose: Pose) => void
}

function itemsOf(pose: Pose, at: number, of: number, acts: PoseActs): MenuItem[] {
  const items: MenuItem[] = [
    { words: 'Rename …', keys: 'F2', act: () => acts.rename(pose.name) },
    { words: 'Up', keys: 'Alt ↑', disabled: at === 0, act: () => acts.move(pose.name, -1) },
    { words: 'Down', keys: 'Alt ↓', disabled: at === of - 1, act: () => acts.move(pose.name, 1) },
  ]
  if (!pose.template && pose.method === 'scan')
    items.push({ words: 'Make it the template', act: () => acts.template(pose.name) })
  if (!pose.template && !isFromMesh(pose))
    items.push({
      words: pose.method === 'fit' ? 'Scan it on its own' : 'Bend the template into it',
      act: () => acts.method(pose),
    })
  if (!pose.template && of > 1)
    items.push({ words: 'Delete, to the bin', keys: 'Del', act: () => acts.remove(pose) })
  return items
}

function noteOf(pose: Pose): string {
  if (pose.template)
    return 'The template: all poses have its net of triangles. Make another one the template before you delete it.'
  if (pose.method === 'fit')
    return `The template is bent into its photographs. A scan of its own needs ${kScan} or more, all round.`
  return 'As the template it gives all poses its net of triangles: the next run makes the others, and the animation, anew.'
}

function usePoseActs(choose: (pose: string) => void, current: string) {
  const { project, tell, complain, reload } = useStudio()
  const [renaming, setRenaming] = useState('')
  const act = async (change: () => Promise<unknown>, words: string, next = '') => {
    try {
      await change()
      await reload()
      if (next) choose(next)
      tell(words)
    } catch (error) {
      complain(error)
    }
  }
  const names = project.poses.map((one) => one.name)
  const acts: PoseActs = {
    rename: setRenaming,
    move: (pose, by) => {
      const at = names.indexOf(pose)
      if (at + by < 0 || at + by >= names.length) return
      const order = names.filter((one) => one !== pose)
      order.splice(at + by, 0, pose)
      void act(() => api.orderPoses(order), `The poses are now: ${order.join(', ')}.`)
    },
    remove: (pose) => {
      if (pose.template || names.length < 2) return tell('The template cannot be deleted.')
      const next = pose.name === current ? names.find((one) => one !== pose.name)! : current
      void act(
        () => api.deletePose(pose.name),
        `${pose.name} is in the bin, below the list of poses. The next run makes the animation without it.`,
        next,
      )
    },
    template: (pose) =>
      void act(
        () => api.chooseTemplate(pose),
        `${pose} is the template: the next run makes the other poses anew.`,
      ),
    method: (pose) =>
      void act(
        () => api.chooseMethod(pose.name, pose.method !== 'fit'),
        pose.method === 'fit'
          ? `The next run scans ${pose.name}.`
          : `The next run bends the template into the photographs of ${pose.name}.`,
      ),
  }
  const rename = (pose: string, name: string) => {
    setRenaming('')
    void act(
      () => api.renamePose(pose, name),
      `${pose} is now called ${name}.`,
      pose === current ? name : '',
    )
  }
  return { acts, renaming, rename, stop: () => setRenaming('') }
}

export function PoseNames(props: { current: Pose; choose: (name: string) => void }) {
  const { project } = useStudio()
  const { current, choose } = props
  const { acts, renaming, rename, stop } = usePoseActs(choose, current.name)
  const [menu, setMenu] = useState<{ pose: string; place: MenuPlace } | null>(null)
  const of = project.poses.length
  const asked = project.poses.find((one) => one.name === menu?.pose)
  const open = (pose: Pose) => (event: MouseEvent) => {
    event.preventDefault()
    setMenu({ pose: pose.name, place: placeOfMenu(event) })
  }
  const key = (pose: Pose) => (event: KeyboardEvent) => {
    const up = { ArrowUp: -1, ArrowDown: 1 }[event.key]
    if (event.key === 'F2') acts.rename(pose.name)
    else if (event.key === 'Delete') acts.remove(pose)
    else if (event.altKey && up) acts.move(pose.name, up)
    else return
    event.preventDefault()
  }
  return (
    <>
      <ul class="list pose-names">
        {project.poses.map((pose) => (
          <li key={pose.name}>
            {renaming === pose.name ? (
              <RenameField
                pose={pose.name}
                done={(name) => rename(pose.name, name)}
                cancel={stop}
              />
            ) : (
              <>
                <button
                  aria-current={pose === current ? 'true' : undefined}
                  onClick={() => choose(pose.name)}
                  onContextMenu={open(pose)}
                  onKeyDown={key(pose)}
                >
                  <span class="name">{pose.name}</span>
                  <PoseFacts pose={pose} />
                </button>
                <button
                  class="quiet more"
                  aria-haspopup="menu"
                  aria-label={`What to do with ${pose.name}`}
                  onClick={open(pose)}
                >
                  ⋯
                </button>
              </>
            )}
          </li>
        ))}
      </ul>
      {menu && asked && (
        <Menu
          label={`What to do with ${asked.name}`}
          items={itemsOf(asked, project.poses.indexOf(asked), of, acts)}
          note={noteOf(asked)}
          place={menu.place}
          close={() => setMenu(null)}
        />
      )}
    </>
  )
}

function PoseFacts({ pose }: { pose: Pose }) {
  return (
    <span class="row facts-end">
      {pose.template && (
        <span class="tag soft" title="All poses have its net of triangles">
          template
        </span>
      )}
      {pose.method === 'fit' && (
        <span class="tag soft" title="The template is bent into its few photographs">
          few
        </span>
      )}
      {!isFromMesh(pose) && (
        <span class="number small soft" title={count(pose.photographs, 'photograph')}>
          {pose.photographs}
          <span class="hidden"> photographs</span>
        </span>
      )}
    </span>
  )
}
